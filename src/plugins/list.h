/** @file
 * The one list of plug-ins. A new plug-in is one .cpp file that defines its register function, and one line
 * here: RECURSE_PLUG_IN(Name) stands for `void registerName(PlugIns&)`.
 */

// Shapes
RECURSE_PLUG_IN(Sphere)
RECURSE_PLUG_IN(Disk)
RECURSE_PLUG_IN(TriangleMesh)
RECURSE_PLUG_IN(PlyMesh)
RECURSE_PLUG_IN(BilinearMesh)
// Materials
RECURSE_PLUG_IN(Diffuse)
RECURSE_PLUG_IN(DiffuseTransmission)
RECURSE_PLUG_IN(OrenNayar)
RECURSE_PLUG_IN(Conductor)
RECURSE_PLUG_IN(Dielectric)
RECURSE_PLUG_IN(ThinDielectric)
RECURSE_PLUG_IN(Coated)
RECURSE_PLUG_IN(Plastic)
RECURSE_PLUG_IN(BlinnPhong)
RECURSE_PLUG_IN(TorranceSparrow)
RECURSE_PLUG_IN(Ward)
RECURSE_PLUG_IN(AshikhminShirley)
RECURSE_PLUG_IN(Measured)
RECURSE_PLUG_IN(Mix)
RECURSE_PLUG_IN(Interface)
// Textures
RECURSE_PLUG_IN(Constant)
RECURSE_PLUG_IN(ImageMap)
RECURSE_PLUG_IN(Scale)
RECURSE_PLUG_IN(MixTextures)
RECURSE_PLUG_IN(Bilerp)
RECURSE_PLUG_IN(Checkerboard)
RECURSE_PLUG_IN(Dots)
RECURSE_PLUG_IN(NoiseTextures)
// Lights
RECURSE_PLUG_IN(Point)
RECURSE_PLUG_IN(Spot)
RECURSE_PLUG_IN(Distant)
RECURSE_PLUG_IN(Infinite)
RECURSE_PLUG_IN(DiffuseArea)
// Cameras, filters and the settings of film and sampler
RECURSE_PLUG_IN(Perspective)
RECURSE_PLUG_IN(Orthographic)
RECURSE_PLUG_IN(Filters)
RECURSE_PLUG_IN(RgbFilm)
RECURSE_PLUG_IN(Samplers)
RECURSE_PLUG_IN(Accelerators)
// Integrators
RECURSE_PLUG_IN(Path)
RECURSE_PLUG_IN(PhotonMapping)
