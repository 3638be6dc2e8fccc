"""Runs inside pvpython for tools/check_exports.py: opens a file and saves the points of its blocks at some times."""

import json
import sys

import numpy as np
from paraview import servermanager, simple
from vtkmodules.util.numpy_support import vtk_to_numpy

job = json.load(open(sys.argv[1]))
# Of the two readers that ParaView offers for XDMF, "T" keeps the names of the grids.
reader = simple.Xdmf3ReaderT(FileName=[job["file"]]) if job["file"].endswith(".xdmf") else simple.OpenDataFile(job["file"])
found = {}


def leaves(data, name):
    """Every data set of a tree of blocks with the innermost name it goes by."""
    if data is None or hasattr(data, "GetPoints"):
        if data is not None:
            yield name, data
        return
    pieces = hasattr(data, "GetNumberOfPieces")
    for i in range(data.GetNumberOfPieces() if pieces else data.GetNumberOfBlocks()):
        about = data.GetMetaData(i)
        own = about.Get(data.NAME()) if about is not None and about.Has(data.NAME()) else name
        yield from leaves(data.GetPiece(i) if pieces else data.GetBlock(i), own)


for k, time in enumerate(job["times"]):
    reader.UpdatePipeline(time)
    for name, data in leaves(servermanager.Fetch(reader), ""):
        if data.GetNumberOfPoints():
            found[f"{name.split('[')[0]}@{k}"] = np.array(vtk_to_numpy(data.GetPoints().GetData()))
np.savez(job["out"], **found)
