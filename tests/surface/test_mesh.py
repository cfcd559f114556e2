"""Meshes: the right way up, to scale, small, and without what was not measured."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from rumu.errors import SurfaceError
from rumu.surface.inflation import inflate
from rumu.surface.mesh import MeshSettings, albedo_srgb, mesh_grid
from rumu.surface.mesh_files import mesh_bytes
from rumu.values import Surface


def surface(h=30, w=40, **changes):
    r, c = np.indices((h, w))
    plain = Surface(
        height=(0.1 * c - 0.2 * r).astype(np.float32),
        normals_from=np.tile(np.array([0, 0, 1], np.float32), (h, w, 1)),
        albedo_from=np.linspace(0, 1, w, dtype=np.float32) * np.ones((h, 1), np.float32),
        mask=np.ones((h, w), dtype=bool),
        confidence=np.ones((h, w), dtype=np.float32),
        spacing=0.5,
        unit="mm",
        source="photometric",
    )
    return replace(plain, **changes)


def loaded(data, kind):
    return trimesh.load(io.BytesIO(data), file_type=kind, force="mesh", process=False)


def test_the_grid_is_in_metres_with_y_up_and_faces_toward_the_viewer():
    grid = mesh_grid(surface())
    assert len(grid.vertices) == 30 * 40 and len(grid.faces) == 2 * 29 * 39
    assert np.allclose(np.ptp(grid.vertices[:, 0]), 39 * 0.0005)
    first, last = grid.vertices[0], grid.vertices[-1]  # top left and bottom right
    assert first[0] < last[0] and first[1] > last[1]
    assert first[2] == pytest.approx(0.0) and last[2] == pytest.approx((0.1 * 39 - 0.2 * 29) / 1000)
    assert np.allclose(grid.vertices[:, :2].mean(axis=0), 0.0, atol=1e-9)
    a, b, c = (grid.vertices[grid.faces[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()
    assert np.allclose(grid.uv[0], (0.5 / 40, 1 - 0.5 / 30))


def test_only_what_was_measured_counts_among_the_triangles():
    mask = np.zeros((300, 400), dtype=bool)
    mask[100:150, 100:140] = True
    for allowed in (500, 5000):
        faces = len(mesh_grid(surface(300, 400, mask=mask), settings=MeshSettings(vertices=allowed)).faces)
        assert min(allowed, 3000) / 2 < faces <= 2 * allowed


def test_what_was_not_measured_is_left_out_but_paper_is_kept():
    mask = np.ones((30, 40), dtype=bool)
    mask[10:20, 15:25] = False
    measured = mesh_grid(surface(mask=mask))
    assert len(measured.vertices) == 30 * 40 - 100
    inside = np.abs(measured.vertices[:, :2]) < (4 * 0.0005, 4 * 0.0005)
    assert not inside.all(axis=1).any()
    assert len(mesh_grid(surface(mask=mask, source="inflation")).vertices) == 30 * 40


def leaning_bar(lean, source, *, half=14.0, n=240):
    """A bar that leans by degrees, and its direction: measured, or inflated from its ink."""
    r, c = np.indices((n, n))
    along = np.array([np.cos(np.radians(lean)), np.sin(np.radians(lean)), 0.0])
    across = along[0] * ((n - 1) / 2 - r) - along[1] * (c - (n - 1) / 2)
    height = 0.6 * np.sqrt(np.maximum(half**2 - across**2, 0)).astype(np.float32)
    if source == "inflation":
        height = inflate(np.abs(across) < half)
    changes = {"height": height, "source": source, "unit": "px", "spacing": 1.0}
    return surface(n, n, **changes), along


@pytest.mark.parametrize("vertices", [60_000, 20_000])
@pytest.mark.parametrize("lean", [8, 30, 45])
@pytest.mark.parametrize(("source", "most"), [("inflation", 7.0), ("photometric", 12.5)])
def test_walls_of_strokes_have_no_teeth_whichever_way_they_lean(source, most, lean, vertices):
    """No part of a straight bar's wall faces along the bar; a wall that is cut across faces 28 to 42 degrees
    along it."""
    found = []
    for way in (lean, -lean):
        bar, along = leaning_bar(way, source)
        grid = mesh_grid(bar, settings=MeshSettings(vertices=vertices))
        a, b, c = (grid.vertices[grid.faces[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        wall = (np.abs(a[:, :2]).max(axis=1) < 0.03) & (normals[:, 2] < 0.95)
        found.append(np.percentile(np.degrees(np.arcsin(np.abs(normals[wall] @ along))), 95))
    assert max(found) < most and found[0] == pytest.approx(found[1], abs=0.5)


def test_exaggeration_and_pixels():
    plain, tall = mesh_grid(surface()), mesh_grid(surface(), settings=MeshSettings(exaggeration=3.0))
    assert np.allclose(tall.vertices, plain.vertices * (1, 1, 3))
    unscaled = mesh_grid(surface(unit="px", spacing=1.0))
    assert np.ptp(unscaled.vertices[:, 0]) == pytest.approx(0.1 * 39 / 40)
    assert unscaled.vertices[-1, 2] == pytest.approx((0.1 * 39 - 0.2 * 29) * 0.1 / 40)


def test_a_large_surface_is_gridded_where_it_lies():
    big = surface(300, 401)
    grid = mesh_grid(big, settings=MeshSettings(vertices=2000))
    assert 1000 < len(grid.vertices) <= 2100
    column = grid.vertices[:, 0] / 0.0005 + 200
    row = 149.5 - grid.vertices[:, 1] / 0.0005
    inner = (column < 390) & (row < 290)
    assert np.allclose(grid.vertices[inner, 2] * 1000, (0.1 * column - 0.2 * row)[inner], atol=1e-5)


def solid(made, **settings):
    """The STL of a surface as a slicer reads it: triangles whose corners are joined where they meet."""
    data = mesh_bytes(made, kind="stl", settings=MeshSettings(**settings))
    mesh = trimesh.load(io.BytesIO(data), file_type="stl", force="mesh")
    assert mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0
    assert mesh.euler_number == 2 and not (mesh.area_faces < 1e-9).any()
    return mesh


@pytest.mark.parametrize(("kind", "pixel"), [("glb", 0.0005), ("ply", 0.5)])
def test_sheets_read_back_in_metres_and_in_millimetres_for_measuring(kind, pixel):
    mesh = loaded(mesh_bytes(surface(), kind=kind), kind)
    assert np.allclose(mesh.extents[:2], np.array([39, 29]) * pixel, rtol=1e-4)
    assert len(mesh.faces) == 2 * 29 * 39
    if kind == "glb":
        assert mesh.visual.material.baseColorTexture.size == (40, 30)
    if kind == "ply":
        assert mesh.visual.vertex_colors[0, 0] == 0 and mesh.visual.vertex_colors[-1, 0] == 255


def test_an_stl_is_a_solid_in_millimetres_on_a_flat_base():
    made = surface()
    mesh = solid(made, base=3.0)
    rise = float(np.ptp(made.height))
    assert np.allclose(mesh.extents, (39 * 0.5, 29 * 0.5, rise + 3.0), atol=1e-4)
    assert mesh.bounds[0, 2] == pytest.approx(-3.0)
    # a slope whose mean height is half its rise, over a flat base
    assert mesh.volume == pytest.approx(39 * 0.5 * 29 * 0.5 * (rise / 2 + 3.0), rel=1e-4)
    below = mesh.face_normals[(mesh.triangles[:, :, 2] == -3.0).all(axis=1)]
    assert len(below) and np.allclose(below, (0, 0, -1))
    corner = mesh.vertices[np.argmin(mesh.vertices @ (1, 1, -0.01))]  # the lower left corner's upper end
    assert corner[2] == pytest.approx(0.0, abs=1e-4)


def test_an_stl_has_the_width_asked_for_and_an_exaggerated_height():
    made = surface()
    mesh = solid(made, width=80.0, base=2.0, exaggeration=2.0)
    scale = 80.0 / (39 * 0.5)
    assert np.allclose(
        mesh.extents, (80.0, 29 * 0.5 * scale, 2 * scale * np.ptp(made.height) + 2.0), rtol=1e-4
    )
    unscaled = surface(unit="px", spacing=1.0)
    assert solid(unscaled).extents[0] == pytest.approx(100.0, rel=1e-6)
    assert solid(replace(unscaled, source="density"), width=60.0).extents[0] == pytest.approx(60.0)


def test_an_stl_is_closed_over_holes_islands_and_missing_edges():
    rng = np.random.default_rng(3)
    for mask in (rng.random((30, 40)) < 0.5, np.eye(30, 40, dtype=bool), np.indices((30, 40))[0] > 20):
        made = surface(mask=mask)
        mesh = solid(made, base=1.5)
        assert np.allclose(mesh.extents[:2], (19.5, 14.5), atol=1e-4)
        assert mesh.extents[2] == pytest.approx(1.5 + np.ptp(made.height[mask]), rel=1e-4)
    hole = np.ones((30, 40), dtype=bool)
    hole[10:20, 15:25] = False
    raised = surface(mask=hole, height=np.where(hole, 4.0, -50.0).astype(np.float32))
    raised.height[0, 0] = 1.0  # the lowest point that was measured, level with the hole's floor
    mesh = solid(raised, base=2.0)
    floor = mesh.vertices[(np.abs(mesh.vertices[:, :2]) < 2).all(axis=1)][:, 2]
    assert {round(float(z), 4) for z in floor} == {0.0, -2.0} or (floor == 0).all()
    assert mesh.extents[2] == pytest.approx(5.0)


@pytest.mark.parametrize(("h", "w"), [(2, 2), (2, 3000), (16, 3000), (900, 901), (3, 17)])
def test_an_stl_of_any_shape_keeps_its_budget(h, w):
    mesh = solid(surface(h, w, unit="px", spacing=1.0), vertices=2000)
    assert len(mesh.faces) <= 4000
    assert mesh.extents[:2].max() == pytest.approx(100.0, rel=1e-5)


def test_an_stl_says_where_its_height_comes_from():
    words = {"photometric": b"measured by photometric", "inflation": b"estimated", "density": b"estimated"}
    for source, word in words.items():
        data = mesh_bytes(surface(source=source), kind="stl")
        assert word in data[:80] and not data.startswith(b"solid")
        assert len(data) == 84 + 50 * int.from_bytes(data[80:84], "little")


def test_a_noisy_photograph_makes_a_glb_under_five_megabytes():
    rng = np.random.default_rng(0)
    big = surface(1500, 1500)
    noisy = replace(big, albedo_from=rng.random((1500, 1500, 3)).astype(np.float32))
    assert len(mesh_bytes(noisy)) <= 5_000_000


def test_srgb():
    assert (albedo_srgb(np.array([[0.0, 0.2140, 1.0]]))[0, :, 0] == (0, 127, 255)).all()


def test_bad_input():
    assert b"\ncomment rumu mesh in mm; relief measured" in mesh_bytes(surface(), kind="ply")[:200]
    with pytest.raises(SurfaceError, match="glb, ply, stl, usdz, got 'obj'"):
        mesh_bytes(surface(), kind="obj")
    with pytest.raises(SurfaceError, match="room for a triangle, got 0 pixels"):
        mesh_bytes(surface(mask=np.zeros((30, 40), dtype=bool)))
    with pytest.raises(SurfaceError, match="room for a triangle, got 0 pixels"):
        mesh_bytes(surface(mask=np.zeros((30, 40), dtype=bool)), kind="stl")
    with pytest.raises(SurfaceError, match="finite exaggeration"):
        MeshSettings(exaggeration=float("nan"))
    for wrong in ({"width": 0.0}, {"width": float("nan")}, {"base": -1.0}, {"base": float("inf")}):
        with pytest.raises(SurfaceError, match=r"from 0.1 to 10000 mm"):
            MeshSettings(**wrong)
