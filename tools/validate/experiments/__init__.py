"""Experiments by subject; experiments.every has them all."""
