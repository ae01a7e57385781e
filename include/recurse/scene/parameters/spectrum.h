/** @file
 * Spectra as scene files give them, and their conversion to linear Rec. 709 RGB, in which Recurse computes.
 *
 * A reflectance or other factor is what it does to daylight D65: it is integrated with the matching functions
 * times D65, and scaled so that a constant spectrum c gives exactly (c, c, c). An emission keeps its colour,
 * and is scaled to luminance 1, as in pbrt-v4. Colours outside the gamut of Rec. 709 are moved towards the
 * grey of their luminance until no component is negative.
 */
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recurse/core/math/rgb.h"
#include "recurse/core/math/vector.h"
#include "recurse/scene/parameters/parsedDirective.h"

namespace recurse {

/** A spectrum by its samples: linear between them, constant beyond them, as in pbrt. */
struct SampledSpectrum {
  std::vector<double> wavelengths; ///< nm, increasing
  std::vector<double> values;
  double at(double wavelength) const;
};

Rgbd rgbOfSpectrum(const SampledSpectrum& spectrum, SpectrumKind kind);
/** Planck's law for a temperature in kelvin. For what is not an emission, the largest value of the spectrum
 * is 1. */
Rgbd rgbOfBlackbody(double kelvin, SpectrumKind kind);
/** One of pbrt's named spectra; empty for a name that is none. */
std::optional<Rgbd> rgbOfNamedSpectrum(const std::string& name);
/** The refractive index of one of its glasses by wavelength; empty for a name that is none. */
std::optional<SampledSpectrum> indexOfNamedGlass(const std::string& name);
/** The range of visible light [nm]. */
constexpr double SHORTEST_WAVELENGTH = 360, LONGEST_WAVELENGTH = 780;
/** What daylight of a wavelength [nm] contributes to white [1/nm], in linear Rec. 709: its integral is (1, 1,
 * 1). Outside the gamut, with components below zero. */
Rgbd daylightColour(double wavelength);
/** Their names. */
const std::vector<std::string>& namedSpectra();
/** Pairs of wavelength and value. Throws Error when they are no spectrum. */
SampledSpectrum spectrumFromPairs(const std::vector<double>& pairs);
/** Reads two columns: wavelength in nm and value; '#' begins a comment. Throws Error. */
SampledSpectrum readSpectrumFile(const std::string& path);
/** What turns the white of a phase of daylight, below 4000 K of a black body, into that of Rec. 709: von
 * Kries adaptation of linear Rec. 709 colours in Bradford's cone space, as in pbrt. */
Mat3d whiteBalance(double kelvin);
/** pbrt's names of colour spaces, for which rgbInColorSpace has primaries and white. */
const std::vector<std::string>& namedColorSpaces();
/** Linear Rec. 709 of an rgb value in a named colour space, moved into the gamut. An emission keeps its
 * colour; a factor is what it does to the white of its space, so that grey stays grey. */
Rgbd rgbInColorSpace(const std::string& name, const Rgbd& value, SpectrumKind kind);
/** CIE XYZ (2°) of linear Rec. 709. */
Vec3d xyzOfRgb(const Rgbd& rgb);
/** Linear Rec. 709 of CIE XYZ (2°), white D65. */
Rgbd rgbOfXyz(const Vec3d& xyz);

} // namespace recurse
