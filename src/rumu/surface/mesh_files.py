"""Meshes as files: GLB and USDZ to look at, PLY to measure, OBJ to exchange, STL to print.

All but STL are open sheets. GLB and USDZ are in metres, as their formats want; PLY, OBJ and STL, which have
no unit, in millimetres. GLB, USDZ and OBJ wear the albedo as a picture; GLB and USDZ also wear the normals,
so that light finds every stroke on a mesh of few triangles: the vertices' own normals are those of the flat
sheet, to which the picture's are relative. The material of a measured surface is matt, since its albedo
already holds all the light that it sends back; ink of estimated relief shines a little.
"""

from __future__ import annotations

import io
import tempfile
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from rumu.errors import SurfaceError
from rumu.surface.mesh import Grid, MeshSettings, albedo_srgb, mesh_grid, solid_mesh
from rumu.values import FloatArray, Source, Surface

Format = Literal["glb", "ply", "stl", "usdz"]

FORMATS: tuple[Format, ...] = get_args(Format)
_SOURCES: dict[Source, str] = {
    "photometric": "relief measured by photometric stereo",
    "inflation": "relief estimated from the outline of the ink, not measured",
    "density": "relief estimated from how dark the ink is, not measured",
}
_MILLIMETRES = 1000.0  # of a metre
_STL_HEADER = "rumu mesh in mm; {}"  # 80 ASCII characters at most; "solid" at the start would mean a text
_TANGENT = "_TANGENT"  # trimesh lets only names with an underscore pass
_MATT = "KHR_materials_specular"
_INK_ROUGHNESS = 0.5  # of ink whose relief is estimated: black would show no relief without any gloss


def mesh_bytes(surface: Surface, *, kind: Format = "glb", settings: MeshSettings | None = None) -> bytes:
    """The mesh as one file.

    Parameters
    ----------
    surface
        What is drawn.
    kind
        'glb' and 'usdz', a sheet with albedo and normals; 'ply', a sheet with coloured vertices; 'stl', a
        closed solid.
    settings
        Exaggeration and sizes.

    Returns
    -------
    bytes
        Colours are in sRGB. GLB and USDZ are in metres; PLY and STL have no unit and are in millimetres, as
        programs that measure and print expect. All say where the height comes from.

    Raises
    ------
    SurfaceError
        For another kind, an empty mesh, or a USDZ without the library that writes it.

    Notes
    -----
    After "glTF 2.0 specification" (Khronos Group 2021) and its extension KHR_materials_specular;
    "UsdPreviewSurface specification" (Pixar).
    """
    import trimesh

    if kind not in FORMATS:
        raise SurfaceError(f"expected a mesh format among {', '.join(FORMATS)}, got {kind!r}")
    settings = settings or MeshSettings()
    if kind == "stl":
        return stl_bytes(*solid_mesh(surface, settings=settings), source=surface.source)
    grid = mesh_grid(surface, settings=settings)
    if kind == "glb":
        return _glb(surface, grid, settings)
    if kind == "usdz":
        return _usdz(surface, grid, settings)
    mesh = trimesh.Trimesh(_MILLIMETRES * grid.vertices, grid.faces, process=False)
    mesh.visual.vertex_colors = _colours(surface, grid)
    comment = f"\ncomment rumu mesh in mm; {_SOURCES[surface.source]}\nelement".encode()
    return bytes(mesh.export(file_type=kind)).replace(b"\nelement", comment, 1)


def obj_files(surface: Surface, name: str, *, settings: MeshSettings | None = None) -> dict[str, bytes]:
    """The mesh as an OBJ with its material and its picture: three files, by their names.

    name: of the OBJ, without .obj. Raises SurfaceError for an empty mesh.
    """
    settings = settings or MeshSettings()
    grid = mesh_grid(surface, settings=settings)
    material, picture = f"{name}.mtl", f"{name}.jpg"
    corners = grid.faces + 1
    lines = [
        f"# rumu mesh in mm; {_SOURCES[surface.source]}",
        f"mtllib {material}",
        "usemtl sheet",
        *(f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in _MILLIMETRES * grid.vertices),
        *(f"vt {u:.7g} {v:.7g}" for u, v in grid.uv),
        *(f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in corners),
    ]
    matt = ["newmtl sheet", "Ka 0 0 0", "Kd 1 1 1", "Ks 0 0 0", "illum 1", f"map_Kd {picture}"]
    return {
        f"{name}.obj": "\n".join([*lines, ""]).encode(),
        material: "\n".join([*matt, ""]).encode(),
        picture: _albedo_picture(surface, settings),
    }


def stl_bytes(vertices: FloatArray, faces: npt.NDArray[np.int64], *, source: Source) -> bytes:
    """A binary STL of a solid. source: where its height comes from, for the header."""
    import trimesh

    data = bytes(trimesh.Trimesh(vertices, faces, process=False).export(file_type="stl"))
    return _STL_HEADER.format(_SOURCES[source]).encode().ljust(80) + data[80:]


# --- pictures on the sheet -------------------------------------------------------------------------


def _jpeg(picture: npt.NDArray[np.uint8], *, quality: int, subsampling: int) -> bytes:
    from PIL import Image

    packed = io.BytesIO()
    Image.fromarray(picture).save(packed, format="JPEG", quality=quality, subsampling=subsampling)
    return packed.getvalue()


def _of_texture_size(array: FloatArray, settings: MeshSettings) -> FloatArray:
    """(h, w) or (h, w, 3): as large as the pictures on the sheet, by means over pixels; never enlarged."""
    import cv2

    height, width = array.shape[:2]
    share = settings.texture / max(height, width)
    if share >= 1.0:
        return array
    size = max(1, round(width * share)), max(1, round(height * share))
    return np.asarray(cv2.resize(array, size, interpolation=cv2.INTER_AREA))


def _albedo_picture(surface: Surface, settings: MeshSettings) -> bytes:
    picture = albedo_srgb(_of_texture_size(surface.albedo, settings))
    return _jpeg(picture, quality=88, subsampling=2)


def normal_levels(surface: Surface, *, settings: MeshSettings) -> npt.NDArray[np.uint8]:
    """(h, w, 3) normals as a picture: n = value / 127.5 - 1, x right, y up (green is up), z toward the eye.

    As steep as the exaggerated surface; level where nothing was measured.
    """
    level = np.array((0, 0, 1), np.float32)
    normals = np.where(surface.mask[..., None], surface.normals, level).astype(np.float32, copy=False)
    normals[..., :2] *= settings.exaggeration
    normals = _of_texture_size(normals, settings)
    normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-6)
    return np.asarray(np.round(normals * 127.5 + 127.5), np.uint8)


def _normal_picture(surface: Surface, settings: MeshSettings) -> bytes:
    return _jpeg(normal_levels(surface, settings=settings), quality=92, subsampling=0)


def _colours(surface: Surface, grid: Grid) -> npt.NDArray[np.uint8]:
    h, w = surface.height.shape
    rows = np.clip(((1.0 - grid.uv[:, 1]) * h).astype(int), 0, h - 1)
    columns = np.clip((grid.uv[:, 0] * w).astype(int), 0, w - 1)
    return np.asarray(albedo_srgb(surface.albedo)[rows, columns])


# --- formats ---------------------------------------------------------------------------------------


def _roughness(surface: Surface) -> float:
    return 1.0 if surface.source == "photometric" else _INK_ROUGHNESS


def _glb(surface: Surface, grid: Grid, settings: MeshSettings) -> bytes:
    import trimesh
    from PIL import Image
    from trimesh.exchange.gltf import export_glb
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial

    albedo, normals = (
        Image.open(io.BytesIO(make(surface, settings))) for make in (_albedo_picture, _normal_picture)
    )
    material = PBRMaterial(
        baseColorTexture=albedo,
        normalTexture=normals,
        metallicFactor=0.0,
        roughnessFactor=_roughness(surface),
    )
    count = len(grid.vertices)
    mesh = trimesh.Trimesh(
        grid.vertices,
        grid.faces,
        vertex_normals=np.tile((0.0, 0.0, 1.0), (count, 1)),
        vertex_attributes={_TANGENT: np.tile(np.array([1, 0, 0, 1], np.float32), (count, 1))},
        visual=TextureVisuals(uv=grid.uv, material=material),
        process=False,
    )

    def finish(tree: dict[str, Any]) -> None:
        tree["asset"]["extras"] = {"relief": _SOURCES[surface.source]}
        if surface.source == "photometric":
            tree["extensionsUsed"] = [_MATT]
            for one in tree["materials"]:
                one["extensions"] = {_MATT: {"specularFactor": 0.0}}
        for one in tree["meshes"]:
            attributes = one["primitives"][0]["attributes"]
            attributes["TANGENT"] = attributes.pop(_TANGENT)

    return bytes(export_glb(trimesh.Scene(mesh), include_normals=True, tree_postprocessor=finish))


def _usdz(surface: Surface, grid: Grid, settings: MeshSettings) -> bytes:
    """A USDZ, by Pixar's own library."""
    try:
        from pxr import UsdUtils
    except ImportError as error:
        raise SurfaceError(
            'expected the library usd-core to write a USDZ; pip install "rumu[usd]"',
            zh='寫 USDZ 需要 usd-core：pip install "rumu[usd]"。',
        ) from error
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "albedo.jpg").write_bytes(_albedo_picture(surface, settings))
        (folder / "normals.jpg").write_bytes(_normal_picture(surface, settings))
        layer, packed = folder / "sheet.usdc", folder / "sheet.usdz"
        _write_stage(str(layer), grid, surface)
        if not UsdUtils.CreateNewUsdzPackage(str(layer), str(packed)):
            raise SurfaceError("the library could not pack the USDZ")
        return packed.read_bytes()


def _write_stage(path: str, grid: Grid, surface: Surface) -> None:
    """The sheet and its material as a USD layer beside its pictures, upright, in metres."""
    from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

    stage = Usd.Stage.CreateNew(path)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, "/Work")
    stage.SetDefaultPrim(root.GetPrim())
    stage.SetMetadata("comment", _SOURCES[surface.source])
    sheet = UsdGeom.Mesh.Define(stage, "/Work/Sheet")
    points = grid.vertices.astype(np.float32)
    sheet.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    sheet.CreateFaceVertexCountsAttr(Vt.IntArray(len(grid.faces), 3))
    sheet.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(grid.faces.astype(np.int32).ravel()))
    sheet.CreateNormalsAttr(Vt.Vec3fArray(len(points), Gf.Vec3f(0, 0, 1)))
    sheet.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    sheet.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    sheet.CreateDoubleSidedAttr(True)
    sheet.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(np.stack([points.min(axis=0), points.max(axis=0)])))
    places = UsdGeom.PrimvarsAPI(sheet).CreatePrimvar(
        "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
    )
    places.Set(Vt.Vec2fArray.FromNumpy(grid.uv.astype(np.float32)))
    UsdShade.MaterialBindingAPI.Apply(sheet.GetPrim()).Bind(_usd_material(stage, surface))
    stage.GetRootLayer().Save()


def _usd_material(stage: Any, surface: Surface) -> Any:
    """The material of a stage's sheet, with the pictures albedo.jpg and normals.jpg."""
    from pxr import Gf, Sdf, UsdShade

    material = UsdShade.Material.Define(stage, "/Work/Paper")
    shader = UsdShade.Shader.Define(stage, "/Work/Paper/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    for name, value in (("roughness", _roughness(surface)), ("metallic", 0.0)):
        shader.CreateInput(name, Sdf.ValueTypeNames.Float).Set(value)
    if surface.source == "photometric":
        shader.CreateInput("useSpecularWorkflow", Sdf.ValueTypeNames.Int).Set(1)
        shader.CreateInput("specularColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(0, 0, 0))
    reader = UsdShade.Shader.Define(stage, "/Work/Paper/Places")
    reader.CreateIdAttr("UsdPrimvarReader_float2")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
    read = reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
    for name, file, space, kind in (
        ("diffuseColor", "./albedo.jpg", "sRGB", Sdf.ValueTypeNames.Color3f),
        ("normal", "./normals.jpg", "raw", Sdf.ValueTypeNames.Normal3f),
    ):
        texture = UsdShade.Shader.Define(stage, f"/Work/Paper/{name}")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(Sdf.AssetPath(file))
        texture.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set(space)
        texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(read)
        if name == "normal":
            texture.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(2, 2, 2, 1))
            texture.CreateInput("bias", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(-1, -1, -1, 0))
        picture = texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)
        shader.CreateInput(name, kind).ConnectToSource(picture)
    shown = shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    material.CreateSurfaceOutput().ConnectToSource(shown)
    return material
