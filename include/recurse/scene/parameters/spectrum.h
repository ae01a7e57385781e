/** @file
 * Spectra of scene files, and their conversion to linear Rec. 709 RGB, the colour space of all computations.
 *
 * A reflectance or other factor is defined by its effect on daylight D65: it is integrated with the matching
 * functions times D65, and scaled so that a constant spectrum c gives exactly (c, c, c). An emission keeps
 * its colour, and is scaled to luminance 1, as in pbrt-v4. Colours outside of the gamut of Rec. 709 are moved
 * towards the grey of their luminance until no component is negative.
 */
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recurse/core/math/rgb.h"
#include "recurse/core/math/vector.h"
#include "recurse/scene/parameters/parsedDirective.h"

namespace recurse {

/** Sampled spectrum: linear between samples, constant beyond them, as in pbrt. */
struct SampledSpectrum {
  std::vector<double> wavelengths; ///< increasing [nm]
  std::vector<double> values;
  double at(double wavelength) const; ///< value at a wavelength [nm]; 0 without samples
};

/** Colour of a spectrum by its use, as defined above. */
Rgbd rgbOfSpectrum(const SampledSpectrum& spectrum, SpectrumKind kind);
/** Colour by Planck's law for a temperature [K]; black unless it is above 0. An emission has luminance 1; the
 * spectrum of any other kind is scaled to a maximum of 1 over all wavelengths. */
Rgbd rgbOfBlackbody(double kelvin, SpectrumKind kind);
/** Colour of one of pbrt's named spectra: refractive indices at a wavelength for each component, illuminants
 * of luminance 1; empty for an unknown name. */
std::optional<Rgbd> rgbOfNamedSpectrum(const std::string& name);
/** Refractive index by wavelength of one of pbrt's named glasses; empty for an unknown name. */
std::optional<SampledSpectrum> indexOfNamedGlass(const std::string& name);
/** The range of visible light [nm]. */
constexpr double SHORTEST_WAVELENGTH = 360, LONGEST_WAVELENGTH = 780;
/** Contribution of daylight of a wavelength [nm] to white [1/nm], in linear Rec. 709; its integral is (1, 1,
 * 1). It is outside of the gamut: components may be negative. Zero beyond the range of visible light. */
Rgbd daylightColour(double wavelength);
/** Names of pbrt's named spectra. */
const std::vector<std::string>& namedSpectra();
/** Spectrum from pairs of wavelength [nm] and value. Throws Error without pairs, and unless the wavelengths
 * are positive and increase. */
SampledSpectrum spectrumFromPairs(const std::vector<double>& pairs);
/** Reads two columns: wavelength [nm] and value; '#' begins a comment. Throws Error. */
SampledSpectrum readSpectrumFile(const std::string& path);
/** Matrix that adapts the white of a colour temperature [K] to the white of Rec. 709: a black body from 1000
 * to 4000 K, daylight above. Von Kries adaptation of linear Rec. 709 colours in Bradford's cone space, as in
 * pbrt. */
Mat3d whiteBalance(double kelvin);
/** Names of pbrt's colour spaces, which rgbInColorSpace() accepts. */
const std::vector<std::string>& namedColorSpaces();
/** Linear Rec. 709 of an rgb value in a colour space of namedColorSpaces(), moved into the gamut; unchanged
 * for "srgb" and an empty name. Throws Error for other names. An emission keeps its colour and luminance; a
 * factor is defined by its effect on the white of its space, so that grey stays grey. */
Rgbd rgbInColorSpace(const std::string& name, const Rgbd& value, SpectrumKind kind);
/** CIE XYZ (2°) of linear Rec. 709. */
Vec3d xyzOfRgb(const Rgbd& rgb);
/** Linear Rec. 709 of CIE XYZ (2°), white D65. */
Rgbd rgbOfXyz(const Vec3d& xyz);

} // namespace recurse
