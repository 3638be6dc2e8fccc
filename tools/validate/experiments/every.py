"""All experiments: importing this registers them, in the order of the page."""
from . import rigid, impacts, rolling, soft, thin, vibrations, grains, fluids, flows, mixed  # noqa: F401
