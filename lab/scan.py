# SPDX-License-Identifier: GPL-2.0-or-later
"""How a surface is filled that has the noise of a scanner: `make bench-large PART=scan`."""

from pathlib import Path

import meshio
import numpy as np

from lab import scenes
from lab.numbers import Topics, table
from lab.reference import Array, Indices, Mesh

NOISE = 0.3  # of a node's shortest edge, either way
NODES = 3000  # to be filled with


def noisy(x: Array, patches: Indices, share: float) -> Array:
    """Nodes of a surface, moved along their normals by up to `share` of their shortest edge, either way."""
    corner, following = x[patches], np.roll(patches, -1, 1)
    normals, shortest = np.zeros_like(x), np.full(len(x), np.inf)
    np.add.at(normals, patches, np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, None])
    edges = np.linalg.norm(corner - x[following], axis=2)
    np.minimum.at(shortest, patches, edges)
    np.minimum.at(shortest, following, edges)
    moved, nodes = x.copy(), np.unique(patches)
    # A number in [0, 1) of 64 bits of MT19937, the low 32 first, as C++'s uniform_real_distribution has it.
    low, high = np.random.RandomState(1)._bit_generator.random_raw(2 * len(nodes)).reshape(-1, 2).T.astype(float)
    by = share * (2.0 * (low + 2.0**32 * high) / 2.0**64 - 1.0)
    moved[nodes] += (by * shortest[nodes])[:, None] * normals[nodes] / np.linalg.norm(normals[nodes], axis=1,
                                                                                      keepdims=True)
    return moved


def filling(mesh: Mesh, folder: Path, nodes: int = NODES) -> Topics:
    """What a run tells of the mesh's surface with noise, filled with so many nodes."""
    at, patches = np.unique(mesh.surface, return_inverse=True)
    folder.mkdir(parents=True, exist_ok=True)
    meshio.write(folder / "scan.off", meshio.Mesh(noisy(mesh.x, mesh.surface, NOISE)[at],
                                                  {"triangle": patches.reshape(-1, 3)}))
    low, high = mesh.x.min(0), mesh.x.max(0)
    below = [*(2.0 * low - high).tolist(), *(2.0 * high - low)[:2].tolist(), float(0.9 * low[2] + 0.1 * high[2])]
    summary = scenes.precompute({
        "name": "scanned", "mesh": {"file": str((folder / "scan.off").resolve()), "node_count": nodes},
        "material": {"young": 1e4, "poisson": 0.3}, "fixed": [{"box": below}], "tables": {"columns": "none"}},
        folder / "tables")
    notes = [note.split(": ", 1)[1] for note in summary["notes"]]
    return {"scan-filling": table(f"notes, of {nodes:,} nodes wanted", [[note] for note in notes])}
