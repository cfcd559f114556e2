"""Files of meshes, opened by other programs' libraries: shape, pictures, material, and what they say."""

from __future__ import annotations

import io
import json
import zipfile
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from PIL import Image
from tests.surface.test_mesh import surface

from rumu.errors import SurfaceError
from rumu.surface.mesh import MeshSettings, mesh_grid
from rumu.surface.mesh_files import mesh_bytes, normal_levels, obj_files


def leaning(degrees=30.0, **changes):
    """A sheet whose normals all lean upward, toward +y."""
    up = np.array([0.0, np.sin(np.deg2rad(degrees)), np.cos(np.deg2rad(degrees))], np.float32)
    plain = surface(**changes)
    return replace(plain, normals_from=np.tile(up, (*plain.height.shape, 1)))


def glb_tree(data):
    length = int.from_bytes(data[12:16], "little")
    return json.loads(data[20 : 20 + length])


def attribute(data, name):
    """The values of an attribute of the only mesh of a GLB, read without a library."""
    tree = glb_tree(data)
    accessor = tree["accessors"][tree["meshes"][0]["primitives"][0]["attributes"][name]]
    view = tree["bufferViews"][accessor["bufferView"]]
    start = 28 + int.from_bytes(data[12:16], "little") + view.get("byteOffset", 0)
    return np.frombuffer(data[start : start + view["byteLength"]], "<f4").reshape(accessor["count"], -1)


def test_a_glb_wears_albedo_and_normals_and_is_matt():
    data = mesh_bytes(leaning(), kind="glb")
    tree = glb_tree(data)
    (material,) = tree["materials"]
    assert material["extensions"] == {"KHR_materials_specular": {"specularFactor": 0.0}}
    assert tree["extensionsUsed"] == ["KHR_materials_specular"]
    assert "measured by photometric stereo" in tree["asset"]["extras"]["relief"]
    assert material["pbrMetallicRoughness"]["roughnessFactor"] == 1.0
    # the picture's normals are relative to those of the flat sheet, x right and y up
    assert np.allclose(attribute(data, "NORMAL"), (0, 0, 1))
    assert np.allclose(attribute(data, "TANGENT"), (1, 0, 0, 1))
    mesh = trimesh.load(io.BytesIO(data), file_type="glb", force="mesh", process=False)
    normals = np.asarray(mesh.visual.material.normalTexture.convert("RGB"), float) / 127.5 - 1
    expected = (0.0, np.sin(np.deg2rad(30)), np.cos(np.deg2rad(30)))  # green is up
    assert np.abs(normals.reshape(-1, 3).mean(axis=0) - expected).max() < 0.02
    albedo = np.asarray(mesh.visual.material.baseColorTexture.convert("L"), float)
    assert albedo[:, 0].mean() < 30 and albedo[:, -1].mean() > 220


def test_ink_whose_relief_is_estimated_keeps_some_gloss():
    tree = glb_tree(mesh_bytes(leaning(source="inflation"), kind="glb"))
    (material,) = tree["materials"]
    assert "extensions" not in material and "extensionsUsed" not in tree
    assert material["pbrMetallicRoughness"]["roughnessFactor"] < 1.0
    assert "not measured" in tree["asset"]["extras"]["relief"]


def test_exaggeration_steepens_the_normals_and_what_was_not_measured_is_level():
    mask = np.ones((30, 40), bool)
    mask[:, :20] = False
    levels = normal_levels(leaning(mask=mask), settings=MeshSettings(exaggeration=3.0))
    normals = levels.astype(float) / 127.5 - 1
    assert np.abs(normals[:, :20] - (0, 0, 1)).max() < 0.01
    slope = normals[:, 20:, 1] / normals[:, 20:, 2]
    assert np.allclose(slope, 3 * np.tan(np.deg2rad(30)), rtol=0.05)


def test_pictures_on_the_sheet_are_as_small_as_they_should_be():
    large = leaning(h=300, w=400)
    assert normal_levels(large, settings=MeshSettings(texture=100)).shape == (75, 100, 3)
    files = obj_files(large, "sheet", settings=MeshSettings(texture=100))
    assert Image.open(io.BytesIO(files["sheet.jpg"])).size == (100, 75)


def test_an_obj_is_read_with_its_material_and_picture(tmp_path):
    made = surface()
    for name, content in obj_files(made, "永 字").items():
        (tmp_path / name).write_bytes(content)
    mesh = trimesh.load(tmp_path / "永 字.obj", force="mesh", process=False)
    grid = mesh_grid(made)
    assert len(mesh.faces) == len(grid.faces)
    millimetres = 1000 * np.array([grid.vertices.min(axis=0), grid.vertices.max(axis=0)])
    assert np.allclose(mesh.bounds, millimetres, atol=1e-4)
    assert mesh.visual.material.image.size == (40, 30)
    text = (tmp_path / "永 字.obj").read_text()
    assert "in mm; relief measured by photometric stereo" in text.splitlines()[0]


def test_a_usdz_passes_the_checker_and_holds_the_sheet(tmp_path):
    from pxr import Usd, UsdGeom, UsdValidation

    made = leaning()
    path = tmp_path / "sheet.usdz"
    path.write_bytes(mesh_bytes(made, kind="usdz"))
    stage = Usd.Stage.Open(str(path))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) > 20
    assert [one.GetMessage() for one in UsdValidation.ValidationContext(validators).Validate(stage)] == []
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0 and UsdGeom.GetStageUpAxis(stage) == "Y"
    sheet = UsdGeom.Mesh(stage.GetPrimAtPath("/Work/Sheet"))
    grid = mesh_grid(made)
    assert np.allclose(np.array(sheet.GetPointsAttr().Get()), grid.vertices, atol=1e-6)
    assert len(sheet.GetFaceVertexIndicesAttr().Get()) == 3 * len(grid.faces)
    assert "measured by photometric stereo" in stage.GetMetadata("comment")
    with zipfile.ZipFile(path) as packed:
        names = sorted(name.rpartition("/")[2] for name in packed.namelist())
        assert names == ["albedo.jpg", "normals.jpg", "sheet.usdc"]
        assert all(one.compress_type == zipfile.ZIP_STORED for one in packed.infolist())


def test_a_usdz_without_its_library_is_told_in_both_languages(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pxr", None)
    with pytest.raises(SurfaceError, match=r"rumu\[usd\]") as told:
        mesh_bytes(surface(), kind="usdz")
    assert "需要 usd-core" in told.value.zh
