"""What an experiment is: a scene, what is read of its run, what theory says, and how near the two must be."""
import itertools
from dataclasses import dataclass, field
from typing import Any, Callable

REGISTRY = {}

PENALTY, ROWS = "penalty", "constraint"
BOTH = (PENALTY, ROWS)


class Case(dict):
    """The parameters of one run, as attributes too: case.h is case["h"]."""
    __getattr__ = dict.__getitem__

    @property
    def label(self):
        return ", ".join(f"{k} {v:g}" if isinstance(v, float) else f"{k} {v}" for k, v in self.items()) or "-"


@dataclass
class Experiment:
    """One line of docs/validation.md for each case.

    scene(case)         the scene, as it would stand in JSON
    measure(case, run)  one figure of the run (Run)
    theory(case)        the same figure by theory
    tolerance           largest error that is promised: |measure - theory| / |theory|, or / scale where scale is given
    misses              {label of a case, or its first parameters: why it is not met}; "" stands for all cases
    study               parameter whose refinement should converge: the order of the error is fitted over it
    curve(case, run)    (x, y) to be drawn, and ideal(case, x) what theory says there
    fast                one of the quick ones that run with the tests
    """
    name: str
    about: str
    law: str
    source: str
    unit: str
    scene: Callable[[Case], dict]
    measure: Callable[[Case, Any], float]
    theory: Callable[[Case], float]
    tolerance: float
    cases: list = field(default_factory=lambda: [Case()])
    scale: float = 0.0
    misses: dict = field(default_factory=dict)
    study: str = ""
    curve: Callable = None
    ideal: Callable = None
    axes: tuple = ("t [s]", "")
    fast: bool = False

    def error(self, case, value):
        wanted = self.theory(case)
        return (value - wanted) / (self.scale or abs(wanted))

    def miss(self, case):
        """Why this case is known not to be met; nothing where it should be."""
        found = [why for label, why in self.misses.items() if f"{case.label}, ".startswith(label + ", " if label else "")]
        return found[0] if found else None


def experiment(**about):
    """Registers the experiment whose scene the decorated function makes; its doc string says what happens."""
    def register(scene):
        name = about.pop("name", scene.__name__)
        if name in REGISTRY:
            raise ValueError(f"two experiments are called {name}")
        theory = about.pop("theory")
        REGISTRY[name] = Experiment(name=name, about=" ".join(scene.__doc__.split()), scene=scene,
                                    theory=theory if callable(theory) else lambda case: theory, **about)
        return scene
    return register


def cases(**lists):
    """Every combination of the given values, the last varying fastest."""
    return [Case(zip(lists, values)) for values in itertools.product(*lists.values())]
