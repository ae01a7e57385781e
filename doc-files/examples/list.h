/** @file
 * The lines that the examples would have in src/plugins/list.h.
 */
RECURSE_PLUG_IN(Minnaert)
RECURSE_PLUG_IN(Polygon)
RECURSE_PLUG_IN(Fisheye)
RECURSE_PLUG_IN(LobeLight)
