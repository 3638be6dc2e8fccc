"""The experiments, by what takes part. Importing one registers it."""
from . import rigid, rolling, soft, thin, grains, fluids, mixed  # noqa: F401
