"""Import this before NumPy or h5py: where this Python lacks them and Debian's own has them, the script starts again with that one.

A second Python often comes first on the PATH (of a notebook, an environment, a container) and has none of them. Where no Python has
them, one line says what to install.
"""

import importlib.util
import os
import subprocess
import sys

DEBIAN = "/usr/bin/python3"


def need(*modules):
    """Returns where this Python has all modules; else starts the script again with one that has them, or ends with exit code 3."""
    missing = [m for m in modules if importlib.util.find_spec(m) is None]
    if not missing:
        return
    other = os.path.realpath(DEBIAN) != os.path.realpath(sys.executable) and os.path.exists(DEBIAN)
    if other and subprocess.run([DEBIAN, "-c", "import " + ", ".join(modules)], stderr=subprocess.DEVNULL).returncode == 0:
        os.execv(DEBIAN, [DEBIAN, *sys.orig_argv[1:]])
    packages = " ".join("python3-" + m.lower() for m in missing)
    print(f"{sys.argv[0]}: {sys.executable} has no {' and no '.join(missing)}{', nor has ' + DEBIAN if other else ''} "
          f"(Debian: apt install {packages})", file=sys.stderr)
    sys.exit(3)
