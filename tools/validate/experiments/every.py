"""All experiments: importing this registers them, in the order of the page."""
from . import rigid, sliding, impacts, classics, structures, rolling, shafts, soft, thin, vibrations, grains, fluids, flows, mixed  # noqa: F401
