"""brim: bodies of any kind in contact through a grid of densities.

A world holds bodies and steps them; a body is added by the keys of an entry of a scene file::

    import brim

    world = brim.World(time_step=1 / 60)
    world.add("obstacle", name="floor", shape=brim.plane())
    ball = world.add("rigid", shape=brim.sphere(0.2), transform={"position": (0, 0, 1)})
    for frame in world.run(frames=60):
        print(frame.time, ball.v)

SI units and right-handed axes with z up, as in scene files. docs/python.md is the tutorial.
"""

from ._core import Defect, InputError, State, StepReport, StepWarning, __version__, set_threads, thread_count
from .articulated import Articulated, Joint, Link
from .body import Body
from .check import check
from .env import Env, Envs
from .link import Attachment
from .own_body import OwnBody
from .plugin import load_plugin
from .query import Hit
from .recorded import Run, RunBody
from .running import Frame, Running, StepError
from .sensor import ContactEvent, RunSensor, Sensor
from .shapes import (blob, bowl, box, capsule, cup, cylinder, gear, l_profile, mesh, plane, sphere, star, torus,
                     u_profile)
from .stress import Stress
from .view import View, view
from .world import World, load

__all__ = [
    "Articulated", "Attachment", "Body", "ContactEvent", "Defect", "Env", "Envs", "Frame", "Hit", "InputError", "Joint", "Link", "OwnBody", "Run", "RunBody",
    "RunSensor", "Running", "Sensor", "State", "StepError", "StepReport", "StepWarning", "Stress", "View", "World", "__version__", "blob", "bowl", "box", "capsule", "check", "cup",
    "cylinder", "gear", "l_profile", "load", "load_plugin", "mesh", "plane", "set_threads", "sphere", "star", "thread_count",
    "torus", "u_profile", "view",
]
