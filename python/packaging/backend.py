"""The build backend of `pip install .` (PEP 517): runs CMake and puts the module into a wheel. Uses the standard library
alone, so that pip has nothing to download in order to build.

--config-settings=build-dir=FOLDER builds in FOLDER instead of build/pip; one that is configured already is taken as it is.
"""

import base64
import hashlib
import os
import re
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SUMMARY = "Bodies of any kind in contact through a grid of densities"


def version():
    return re.search(r"project\(brim VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]


def metadata():
    return (f"Metadata-Version: 2.1\nName: brim\nVersion: {version()}\nSummary: {SUMMARY}\nLicense: Apache-2.0\n"
            "Requires-Python: >=3.9\nRequires-Dist: numpy>=1.22\n")


def tag():
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


def run(*command):
    # pip's own paths would hide the packages of the Python that the module is built for.
    environment = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "PYTHONNOUSERSITE")}
    subprocess.run([str(word) for word in command], check=True, cwd=ROOT, env=environment)


def build(folder):
    if not (folder / "CMakeCache.txt").exists():
        run("cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DBRIM_TESTS=OFF",
            "-DBRIM_BENCH=OFF", "-DBRIM_PYTHON=ON", f"-DPython_EXECUTABLE={sys.executable}")
    run("cmake", "--build", folder, "--target", "brim_python", "brim_cli")
    module = folder / "python" / "brim" / f"_core{sysconfig.get_config_var('EXT_SUFFIX')}"
    if not module.exists():
        raise SystemExit(f"{module} was not built: {folder} is configured for another Python; "
                         "take another folder with --config-settings=build-dir=FOLDER")


def contents(folder):
    """[(name in the wheel, file)]: the package, the program and the page that World.show serves."""
    package = folder / "python" / "brim"
    found = [(f"brim/{path.name}", path) for path in sorted(package.iterdir())
             if path.suffix in (".py", ".pyi", ".so", ".typed") or path.name == "py.typed"]
    found.append(("brim/bin/brim", folder / "brim"))
    page = ROOT / "viewer" / "dist"
    found += [(f"brim/share/brim/viewer/{path.relative_to(page).as_posix()}", path)
              for path in sorted(page.rglob("*")) if path.is_file()]
    return found


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    folder = (ROOT / (config_settings or {}).get("build-dir", "build/pip")).resolve()
    build(folder)
    name = f"brim-{version()}-{tag()}.whl"
    info = f"brim-{version()}.dist-info"
    wheel = f"Wheel-Version: 1.0\nGenerator: brim\nRoot-Is-Purelib: false\nTag: {tag()}\n"
    entries = [(where, path.read_bytes(), path.stat().st_mode & 0o777) for where, path in contents(folder)]
    entries += [(f"{info}/METADATA", metadata().encode(), 0o644), (f"{info}/WHEEL", wheel.encode(), 0o644),
                (f"{info}/LICENSE", (ROOT / "LICENSE").read_bytes(), 0o644)]
    record = []
    with zipfile.ZipFile(Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as archive:
        for where, data, mode in entries:
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record.append(f"{where},sha256={digest},{len(data)}")
            write(archive, where, data, mode)
        record.append(f"{info}/RECORD,,\n")
        write(archive, f"{info}/RECORD", "\n".join(record).encode(), 0o644)
    return name


def write(archive, where, data, mode):
    entry = zipfile.ZipInfo(where, (2020, 1, 1, 0, 0, 0))
    entry.external_attr = (0o100000 | mode) << 16
    entry.compress_type = zipfile.ZIP_DEFLATED
    archive.writestr(entry, data)


def build_sdist(sdist_directory, config_settings=None):
    raise SystemExit("brim is installed from its checkout: pip install .")
