"""The validation suite: experiments with an analytic or measured answer, run with `brim` (./dev validate; docs/validation.md)."""
