"""All experiments: importing this registers them, in the order of the page."""
from . import rigid, rolling, soft, thin, grains, fluids, mixed  # noqa: F401
