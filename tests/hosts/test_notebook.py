"""The notebook: it runs from top to bottom, shows what it says, and is kept without what it shows."""

import os

import nbformat
import pytest
from conftest import ROOT
from nbclient import NotebookClient

pytestmark = pytest.mark.all

NOTEBOOK = ROOT / "examples/five_minutes.ipynb"


def test_the_notebook_leads_to_figure_5(tmp_path):
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    environment = os.environ | {"PYTHONPATH": str(ROOT / "python"), "IPYTHONDIR": str(tmp_path)}
    client = NotebookClient(
        notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
    )
    client.execute(env=environment)
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 4
    printed = "".join(output["text"] for output in outputs if output["output_type"] == "stream")
    assert "5 balls" in printed
    assert "in the order in which they close: [[2], [1, 3], [2, 4], [3]]" in printed
    assert not any(output.get("name") == "stderr" for output in outputs)


def test_the_notebook_is_kept_without_outputs():
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert cells and all(cell.outputs == [] and cell.execution_count is None for cell in cells)
