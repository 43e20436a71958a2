# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's shader nodes by the core's names: all that the export knows about single nodes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from . import node_inputs, values, versions


@dataclass(frozen=True)
class NodeType:
    """How one kind of node is written down.

    Parameters
    ----------
    op : str or None
        Name of the operation; None is a constant, held by the node's output.
    inputs : mapping of str to str
        Input names that differ from the socket's own (identifier in snake case).
    properties : mapping of str to str
        Node properties that are copied: Blender's name to the core's.
    expected : mapping of str to object
        Node properties without counterpart in the core, and the only value that is rendered right.
    variant : str
        Node property whose value, in lower case, is appended to `op`: there is an operation for each.
    outputs : mapping of str to str
        Output names that differ from the socket's own.
    fixed : mapping of str to object
        Properties of the operation that all nodes of this kind have.
    read : callable, optional
        ``read(node)`` gives further properties, a mapping, from what is not a plain value in Blender.
    """

    op: str | None
    inputs: Mapping[str, str] = field(default_factory=dict)
    properties: Mapping[str, str] = field(default_factory=dict)
    expected: Mapping[str, object] = field(default_factory=dict)
    variant: str = ""
    outputs: Mapping[str, str] = field(default_factory=dict)
    fixed: Mapping[str, object] = field(default_factory=dict)
    read: Callable[[object], dict] | None = None

    def operation(self, node):
        """Name of the operation that `node` is."""
        return f"{self.op}_{getattr(node, self.variant).lower()}" if self.variant else self.op


def _same(*names):
    return {name: name for name in names}


_SHADERS = {"shader": "a", "shader_001": "b"}
_DISTRIBUTION = _same("distribution")
_GLOSSY = NodeType("glossy", properties=_DISTRIBUTION)
_ABC = {"value": "a", "value_001": "b", "value_002": "c", "vector": "a", "vector_001": "b", "vector_002": "c"}
_MIX_INPUTS = {f"{name}_{kind}": name for kind in ("float", "vector", "color") for name in ("factor", "a", "b")}
_MIX_OUTPUTS = {f"result_{kind}": "result" for kind in ("float", "vector", "color")}
_RANGE = {f"{end}_{limit}_float3": f"{end}_{limit}" for end in ("from", "to") for limit in ("min", "max")}
_RANGE |= {"vector": "value", "steps_float3": "steps"}


def _letters(*theirs):
    """Names of the sockets of an older Combine or Separate node."""
    return dict(zip(theirs, ("red", "green", "blue"), strict=True))


_SKY = _same("sky_type", "turbidity", "ground_albedo", "altitude", "air_density", "aerosol_density", "ozone_density")
_SKY |= _same("sun_disc", "sun_size", "sun_intensity", "sun_elevation", "sun_rotation")
_SKY |= {"dust_density": "aerosol_density"}  # before 5.0


NODES = {
    # Closures
    "ShaderNodeBsdfPrincipled": NodeType(
        "principled", properties=_same("distribution", "subsurface_method"), fixed=versions.older_principled()
    ),
    "ShaderNodeBsdfDiffuse": NodeType("diffuse", fixed=versions.older_diffuse()),
    "ShaderNodeBsdfGlossy": _GLOSSY,
    "ShaderNodeBsdfAnisotropic": _GLOSSY,
    "ShaderNodeBsdfGlass": NodeType("glass", properties=_DISTRIBUTION),
    "ShaderNodeBsdfRefraction": NodeType("refraction", properties=_DISTRIBUTION),
    "ShaderNodeBsdfTranslucent": NodeType("translucent"),
    "ShaderNodeBsdfTransparent": NodeType("transparent"),
    "ShaderNodeEmission": NodeType("emission"),
    "ShaderNodeBackground": NodeType("background"),
    "ShaderNodeBsdfMetallic": NodeType("metallic", properties=_same("distribution", "fresnel_type")),
    "ShaderNodeBsdfSheen": NodeType("sheen", properties=_DISTRIBUTION),
    "ShaderNodeBsdfToon": NodeType("toon", properties=_same("component")),
    "ShaderNodeSubsurfaceScattering": NodeType("subsurface"),
    "ShaderNodeBsdfHair": NodeType("hair", properties=_same("component")),
    "ShaderNodeBsdfHairPrincipled": NodeType("principled_hair", properties=_same("model", "parametrization")),
    "ShaderNodeBsdfRayPortal": NodeType("ray_portal"),
    "ShaderNodeHoldout": NodeType("holdout"),
    "ShaderNodeVolumeAbsorption": NodeType("volume"),
    "ShaderNodeVolumeScatter": NodeType("volume"),
    "ShaderNodeVolumePrincipled": NodeType("volume"),
    "ShaderNodeVolumeCoefficients": NodeType("volume"),
    "ShaderNodeMixShader": NodeType("mix_shader", inputs=_SHADERS),
    "ShaderNodeAddShader": NodeType("add_shader", inputs=_SHADERS),
    # Textures and coordinates
    "ShaderNodeTexImage": NodeType(
        "image", properties=_same("image", "interpolation", "projection", "projection_blend", "extension")
    ),
    "ShaderNodeTexEnvironment": NodeType("environment", properties=_same("image", "interpolation", "projection")),
    "ShaderNodeTexChecker": NodeType("checker"),
    "ShaderNodeTexNoise": NodeType("noise", properties=_same("noise_dimensions", "noise_type", "normalize")),
    "ShaderNodeTexWhiteNoise": NodeType("white_noise", properties=_same("noise_dimensions")),
    "ShaderNodeTexWave": NodeType(
        "wave", properties=_same("wave_type", "bands_direction", "rings_direction", "wave_profile")
    ),
    "ShaderNodeTexMagic": NodeType("magic", properties=_same("turbulence_depth")),
    "ShaderNodeTexGradient": NodeType("gradient", properties=_same("gradient_type")),
    "ShaderNodeTexBrick": NodeType(
        "brick", properties=_same("offset", "offset_frequency", "squash", "squash_frequency")
    ),
    "ShaderNodeTexGabor": NodeType("gabor", properties=_same("gabor_type")),
    "ShaderNodeTexSky": NodeType("sky", properties=_SKY, read=values.sun_direction),
    "ShaderNodeTexVoronoi": NodeType(
        versions.voronoi_operation(),
        properties=_same("voronoi_dimensions", "distance", "feature", "normalize"),
        fixed=versions.older_voronoi(),
    ),
    "ShaderNodeTexIES": NodeType("ies", read=node_inputs.ies, fixed=versions.older_ies()),
    "ShaderNodeMapping": NodeType("mapping", properties=_same("vector_type")),
    # Inputs
    "ShaderNodeTexCoord": NodeType(
        "tex_coord",
        properties=_same("from_instancer"),
        fixed=versions.texture_coordinate(),
        read=node_inputs.texture_coordinate,
    ),
    "ShaderNodeUVMap": NodeType("uv_map", properties=_same("uv_map", "from_instancer")),
    "ShaderNodeNewGeometry": NodeType("geometry"),
    "ShaderNodeAttribute": NodeType("attribute", properties=_same("attribute_type", "attribute_name")),
    "ShaderNodeVertexColor": NodeType("vertex_color", properties=_same("layer_name")),
    "ShaderNodeObjectInfo": NodeType("object_info"),
    "ShaderNodeParticleInfo": NodeType("particle_info"),
    "ShaderNodeHairInfo": NodeType("hair_info"),
    "ShaderNodePointInfo": NodeType("point_info"),
    "ShaderNodeCameraData": NodeType("camera_data"),
    "ShaderNodeLightPath": NodeType("light_path"),
    "ShaderNodeFresnel": NodeType("fresnel"),
    "ShaderNodeLayerWeight": NodeType("layer_weight"),
    "ShaderNodeTangent": NodeType("tangent", properties=_same("direction_type", "axis", "uv_map")),
    "ShaderNodeWireframe": NodeType("wireframe", properties=_same("use_pixel_size")),
    "ShaderNodeBevel": NodeType("bevel", properties=_same("samples")),
    "ShaderNodeAmbientOcclusion": NodeType("ambient_occlusion", properties=_same("samples", "inside", "only_local")),
    # Normals
    "ShaderNodeNormalMap": NodeType(
        "normal_map", properties=_same("space", "uv_map", "convention"), fixed=versions.normal_map()
    ),
    "ShaderNodeBump": NodeType("bump", properties=_same("invert")),
    "ShaderNodeDisplacement": NodeType("displacement", properties=_same("space")),
    "ShaderNodeVectorDisplacement": NodeType("vector_displacement", properties=_same("space")),
    # Converters and colours
    "ShaderNodeMath": NodeType("math", inputs=_ABC, properties=_same("use_clamp"), variant="operation"),
    "ShaderNodeVectorMath": NodeType("vector_math", inputs=_ABC, variant="operation"),
    "ShaderNodeMix": NodeType(
        "mix",
        inputs=_MIX_INPUTS,
        properties=_same("blend_type", "clamp_factor", "clamp_result"),
        variant="data_type",
        outputs=_MIX_OUTPUTS,
    ),
    "ShaderNodeMixRGB": NodeType(
        "mix_rgba",
        inputs={"fac": "factor", "color1": "a", "color2": "b"},
        properties={"blend_type": "blend_type", "use_clamp": "clamp_result"},
        outputs={"color": "result"},
    ),
    "ShaderNodeMapRange": NodeType(
        "map_range", inputs=_RANGE, properties=_same("clamp", "interpolation_type"), variant="data_type"
    ),
    "ShaderNodeClamp": NodeType("clamp_range", properties=_same("clamp_type")),
    "ShaderNodeValToRGB": NodeType("color_ramp", read=values.color_ramp),
    "ShaderNodeRGBCurve": NodeType(
        "rgb_curves", inputs={"color": "value"}, outputs={"color": "value"}, read=values.rgb_curves
    ),
    "ShaderNodeVectorCurve": NodeType(
        "vector_curves", inputs={"vector": "value"}, outputs={"vector": "value"}, read=values.vector_curves
    ),
    "ShaderNodeFloatCurve": NodeType("float_curve", read=values.float_curve),
    "ShaderNodeHueSaturation": NodeType("hue_saturation"),
    "ShaderNodeInvert": NodeType("invert"),
    "ShaderNodeGamma": NodeType("gamma"),
    "ShaderNodeBrightContrast": NodeType("bright_contrast"),
    "ShaderNodeRGBToBW": NodeType("rgb_to_bw"),
    "ShaderNodeCombineXYZ": NodeType("combine_xyz"),
    "ShaderNodeSeparateXYZ": NodeType("separate_xyz"),
    "ShaderNodeCombineColor": NodeType("combine_color", properties=_same("mode")),
    "ShaderNodeSeparateColor": NodeType("separate_color", properties=_same("mode")),
    "ShaderNodeBlackbody": NodeType("blackbody"),
    "ShaderNodeWavelength": NodeType("wavelength"),
    "ShaderNodeVectorRotate": NodeType("vector_rotate", properties=_same("invert"), variant="rotation_type"),
    "ShaderNodeVectorTransform": NodeType(
        "vector_transform", properties=_same("vector_type", "convert_from", "convert_to")
    ),
    "ShaderNodeNormal": NodeType("normal", read=values.direction),
    "ShaderNodeLightFalloff": NodeType("light_falloff"),
    # Converters of Blender before 5.0
    "ShaderNodeCombineRGB": NodeType("combine_color", inputs=_letters("r", "g", "b"), outputs={"image": "color"}),
    "ShaderNodeCombineHSV": NodeType("combine_color", inputs=_letters("h", "s", "v"), fixed={"mode": "HSV"}),
    "ShaderNodeSeparateRGB": NodeType("separate_color", inputs={"image": "color"}, outputs=_letters("r", "g", "b")),
    "ShaderNodeSeparateHSV": NodeType("separate_color", outputs=_letters("h", "s", "v"), fixed={"mode": "HSV"}),
    # Constants
    "ShaderNodeRGB": NodeType(None),
    "ShaderNodeValue": NodeType(None),
}
