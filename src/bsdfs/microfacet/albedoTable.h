/** @file
 * Directional albedo of a lobe, tabulated over the cosine and the roughness. It serves the energy
 * compensation of single-scattering models, and layers that divide the incident energy.
 */
#pragma once

#include <vector>

#include "recurse/core/sampling/sampling.h"

namespace recurse {

class AlbedoTable {
 public:
  AlbedoTable() = default;
  /** `albedo(wi, alpha, u)` is the weight of one sample for a direction with wi.y = 0, wi.z > 0; it is
   * averaged over u. Roughness is in [least, most]; equal bounds need one row. */
  template <class F>
  AlbedoTable(float least, float most, const F& albedo, int rowsBetween = 20)
      : least(least), most(most), rows(most > least ? rowsBetween : 1) {
    values.resize(static_cast<size_t>(rows * COLUMNS));
    means.resize(static_cast<size_t>(rows));
    const int strata = rows > 1 ? 24 : 48;
    for (int row = 0; row < rows; ++row) {
      const float s = rows > 1 ? static_cast<float>(row) / static_cast<float>(rows - 1) : 0;
      const float alpha = least + square(s) * (most - least);
      for (int column = 0; column < COLUMNS; ++column) {
        const float cosine = std::max(square(static_cast<float>(column) / (COLUMNS - 1)), 1e-4f);
        const Vec3f wi(std::sqrt(1 - square(cosine)), 0, cosine);
        double sum = 0, weights = 0;
        for (int i = 0; i < strata; ++i)
          for (int j = 0; j < strata; ++j) {
            const Vec2f s = Vec2f(static_cast<float>(i) + 0.5f, static_cast<float>(j) + 0.5f) /
                            static_cast<float>(strata);
            // Strata are narrower at the ends of each axis, the tails of a lobe.
            const Vec2f u = s * s * (3.0f - 2.0f * s), widths = 6.0f * s * (1.0f - s);
            const float weight = widths.x * widths.y;
            sum += static_cast<double>(weight * albedo(wi, alpha, u));
            weights += static_cast<double>(weight);
          }
        values[static_cast<size_t>(row * COLUMNS + column)] =
            std::min(static_cast<float>(sum / weights), 1.0f);
      }
      // 2 ∫ E(μ) μ dμ = 4 ∫ E t³ dt with μ = t², E linear in t between the columns.
      double mean = 0;
      for (int c = 0; c + 1 < COLUMNS; ++c) {
        const double a = double(c) / (COLUMNS - 1), b = double(c + 1) / (COLUMNS - 1), h = b - a;
        const double ea = double(values[size_t(row * COLUMNS + c)]),
                     eb = double(values[size_t(row * COLUMNS + c + 1)]);
        const double cubes = (square(square(b)) - square(square(a))) / 4;
        const double fourths = (square(square(b)) * b - square(square(a)) * a) / 5;
        mean += 4 * (ea * cubes + (eb - ea) / h * (fourths - a * cubes));
      }
      means[static_cast<size_t>(row)] = static_cast<float>(mean);
    }
  }

  bool empty() const { return values.empty(); }
  /** Albedo for light from a direction with this |cosine|. */
  float at(float cosine, float alpha) const {
    const float x = std::sqrt(std::clamp(cosine, 0.0f, 1.0f)) * (COLUMNS - 1);
    const int column = std::min(static_cast<int>(x), COLUMNS - 2);
    const float fx = x - static_cast<float>(column);
    const auto inRow = [&](int row) {
      const float* v = &values[static_cast<size_t>(row * COLUMNS + column)];
      return v[0] + (v[1] - v[0]) * fx;
    };
    return overRows(alpha, inRow);
  }
  /** Albedo for uniform diffuse light: the cosine-weighted mean. */
  float mean(float alpha) const {
    return overRows(alpha, [&](int row) { return means[static_cast<size_t>(row)]; });
  }

 private:
  static constexpr int COLUMNS = 40;

  template <class F> float overRows(float alpha, const F& inRow) const {
    if (rows == 1) return inRow(0);
    const float y =
        std::sqrt(std::clamp((alpha - least) / (most - least), 0.0f, 1.0f)) * static_cast<float>(rows - 1);
    const int row = std::min(static_cast<int>(y), rows - 2);
    const float fy = y - static_cast<float>(row), low = inRow(row);
    return low + (inRow(row + 1) - low) * fy;
  }

  float least = 0, most = 0;
  int rows = 0;
  std::vector<float> values, means;
};

} // namespace recurse
