"""Kinds together."""
import numpy as np

from validate.experiment import BOTH, cases, experiment
from validate.scenes import G, block, box, floor, rigid, scene

UPPER = ("finite_elements", "mass_spring", "meshless", "soft_image", "cloth")


@experiment(law="F = (m₁ + m₂ + m₃) g", source="statics", unit="N", tolerance=0.005, theory=lambda c: 1.0, cases=[c for c in cases(response=BOTH, kind=UPPER) if c.response == "penalty" or c.kind in ("meshless", "soft_image")],
            measure=lambda c, r: -np.mean(r.force("plane")[-20:, 2]) / (G * (r.mass("soft") + r.mass("above") + r.mass("below"))))
def sandwich(case):
    """A body that deforms between two rigid plates on a floor: the load that the floor carries, over the weights."""
    h = 0.025
    top = 0.06 if case.kind == "cloth" else 0.15
    return scene([floor(h), rigid("below", box(0.4, 0.4, 0.1), (0, 0, 0.05), h),
                  block(case.kind, "soft", (0, 0, 0.1), young=5e5), rigid("above", box(0.3, 0.3, 0.05), (0, 0, 0.1 + top + 0.026), h)],
                 1.2, response=case.response)


@experiment(law="momentum is conserved", source="Newton", unit="kg m/s", tolerance=1e-6, theory=0.0, scale=1.0, fast=True,
            cases=cases(response=BOTH, kind=("finite_elements", "mass_spring", "meshless", "soft_image", "cloth")),
            measure=lambda c, r: float(np.linalg.norm(sum(r.mass(n) * (r.velocity(n)[-1] - r.velocity(n)[0]) for n in ("one", "two")))))
def closed_system(case):
    """A body that deforms and a rigid box collide without weight: what the sum of their momenta changes by, over about 1 kg m/s."""
    return scene([block(case.kind, "one", (0, 0, 0), velocity=(0, 0, 1), young=5e5),
                  rigid("two", box(0.3, 0.3, 0.1), (0.05, 0, 0.35), 0.025, velocity=[0, 0, -1])], 0.6, gravity=[0, 0, 0], response=case.response)
