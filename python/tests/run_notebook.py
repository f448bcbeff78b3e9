# SPDX-License-Identifier: GPL-2.0-or-later
"""run_notebook.py NOTEBOOK FOLDER: executes it with FOLDER as the current one; an exception in a cell is one here.
Needs nbclient and ipykernel."""
import sys

import nbformat
from nbclient import NotebookClient

notebook = nbformat.read(sys.argv[1], as_version=4)
NotebookClient(notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": sys.argv[2]}}).execute()
print(sum(cell.cell_type == "code" for cell in notebook.cells), "cells ran")
