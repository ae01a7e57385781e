/** @file
 * Reflectance of a thin film, integrated over all wavelengths (derivation: doc-files/notes/thin-films.md).
 */
#include "bsdfs/microfacet/thinFilm.h"

#include <array>
#include <cmath>

#include "recurse/scene/parameters/spectrum.h"

namespace recurse {

namespace {

using Complex = std::complex<double>;

/**
 * Fourier transform of the colour of daylight: S(D) = ∫ w(λ) exp(2πi D / λ) dλ for each channel, where D is
 * an optical path difference [nm]; S(0) = 1 (equation 4 of the note). Cubic Hermite interpolation.
 */
class DaylightCoherence {
 public:
  static constexpr double STEP = 20, LONGEST = 40000; ///< [nm]; |S| < 2e-4 beyond

  DaylightCoherence() : nodes(static_cast<size_t>(LONGEST / STEP) + 2) {
    Rgbd white(0);
    for (double w = SHORTEST_WAVELENGTH + 0.5; w < LONGEST_WAVELENGTH; ++w) white += daylightColour(w);
    for (double w = SHORTEST_WAVELENGTH + 0.5; w < LONGEST_WAVELENGTH; ++w) {
      const Rgbd colour = daylightColour(w) / white;
      const double wavenumber = 2 * M_PI / w;
      // exp(2πi D / λ) from node to node by multiplication.
      const Complex turn = std::polar(1.0, wavenumber * STEP);
      Complex phase = 1;
      for (Node& node : nodes) {
        const Complex slope = phase * Complex(0, wavenumber * STEP);
        for (int c = 0; c < 3; ++c) {
          node.value[size_t(c)] += std::complex<float>(phase * colour[c]);
          node.slope[size_t(c)] += std::complex<float>(slope * colour[c]);
        }
        phase *= turn;
      }
    }
  }

  /** S(D) for 0 <= D < LONGEST. */
  std::array<std::complex<float>, 3> at(double difference) const {
    const double position = difference / STEP;
    const auto i = static_cast<size_t>(position);
    const auto t = static_cast<float>(position - double(i));
    const Node &a = nodes[i], &b = nodes[i + 1];
    const float t2 = t * t, t3 = t2 * t;
    std::array<std::complex<float>, 3> out;
    for (size_t c = 0; c < 3; ++c)
      out[c] = (2 * t3 - 3 * t2 + 1) * a.value[c] + (t3 - 2 * t2 + t) * a.slope[c] +
               (3 * t2 - 2 * t3) * b.value[c] + (t3 - t2) * b.slope[c];
    return out;
  }

 private:
  struct Node {
    std::array<std::complex<float>, 3> value{}, slope{}; ///< derivative by D / STEP
  };
  std::vector<Node> nodes;
};

const DaylightCoherence& daylightCoherence() {
  static const DaylightCoherence ALL;
  return ALL;
}

} // namespace

Rgb ThinFilm::reflectance(float cosOutside, const Rgb& baseEta, const Rgb& baseK) const {
  constexpr double NEGLIGIBLE = 1e-5; // bound of all further terms, below what half floats can show
  if (!(cosOutside > 0)) return Rgb(1);
  const double c = std::min(cosOutside, 1.0f), sin2 = 1 - c * c, film2 = square(double(eta));
  const double inFilm = std::sqrt(film2 - sin2); // index times cosine, as all that follows
  const std::array<double, 2> outer = {(c - inFilm) / (c + inFilm),
                                       (film2 * c - inFilm) / (film2 * c + inFilm)};
  struct Term {
    Complex ratio, power{1}; ///< u and u^m
    double sum = 0, scale = 0;
    double size = 0; ///< bound of this and all further terms
  };
  std::array<std::array<Term, 2>, 3> terms; // of channels and polarisations
  for (int channel = 0; channel < 3; ++channel) {
    const Complex base2 = square(Complex(baseEta[channel], baseK[channel])), inBase = std::sqrt(base2 - sin2);
    const std::array<Complex, 2> inner = {(inFilm - inBase) / (inFilm + inBase),
                                          (base2 * inFilm - film2 * inBase) /
                                              (base2 * inFilm + film2 * inBase)};
    for (size_t p = 0; p < 2; ++p) {
      Term& term = terms[size_t(channel)][p];
      const double absorbed = 1 - std::norm(inner[p]);
      if (!(absorbed > 0)) continue; // total reflection, or 0/0 at an index of 0
      term.ratio = -outer[p] * inner[p];
      term.scale = (1 - square(outer[p])) * absorbed / (1 - std::norm(term.ratio));
      term.size = term.scale / (1 - std::abs(term.ratio));
    }
  }
  const double difference = 2 * double(thickness) * inFilm;
  double largest = 1;
  for (int m = 1; largest > NEGLIGIBLE && m * difference < DaylightCoherence::LONGEST; ++m) {
    const auto coherence = daylightCoherence().at(m * difference);
    largest = 0;
    for (size_t channel = 0; channel < 3; ++channel)
      for (Term& term : terms[channel]) {
        term.power *= term.ratio;
        term.sum += 2 * (term.power * Complex(coherence[channel])).real();
        largest = std::max(largest, std::abs(term.power) * term.size);
      }
  }
  Rgb out;
  for (int channel = 0; channel < 3; ++channel) {
    double transmitted = 0;
    for (const Term& term : terms[size_t(channel)]) transmitted += term.scale * (1 + term.sum) / 2;
    out[channel] = static_cast<float>(std::clamp(1 - transmitted, 0.0, 1.0));
  }
  return out;
}

void addThinFilmParameters(std::vector<ParameterSpec>& parameters) {
  parameters.push_back(realParameter("thinfilm.thickness", "0",
                                     "thickness of a thin film on the outer side [nm], whose interference "
                                     "colours the reflection; 0: no film")
                           .range(0, 1e5)
                           .withTexture());
  parameters.push_back(
      realParameter("thinfilm.eta", "1.33", "refractive index of the film over that of the outside")
          .range(1, 10)
          .withTexture());
}

ThinFilmParameters::ThinFilmParameters(const Parameters& p, const TextureLookup& textures)
    : thickness(textures.real(p, "thinfilm.thickness")), eta(textures.real(p, "thinfilm.eta")) {
  if (p.has("thinfilm.eta") && !exists())
    p.warn("thinfilm.eta", "there is no film: \"thinfilm.thickness\" is 0");
}

} // namespace recurse
