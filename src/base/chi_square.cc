#include "planegraph/base/chi_square.h"

#include <cmath>
#include <stdexcept>

namespace planegraph {

double ChiSquareTail(double x, int degrees) {
  const double half = 0.5 * x;
  if (half <= 0.0) return 1.0;
  double tail = degrees % 2 == 1 ? std::erfc(std::sqrt(half)) : 0.0;
  for (int k = degrees % 2; k < degrees; k += 2) {  // by logarithms: exp(-half) alone may be 0
    tail += std::exp(0.5 * k * std::log(half) - half - std::lgamma(0.5 * k + 1.0));
  }
  return tail;
}

double ChiSquareQuantile(double probability, int degrees) {
  if (!(probability > 0.0 && probability < 1.0) || degrees < 1) {
    throw std::invalid_argument("ChiSquareQuantile: probability or degrees");
  }
  double low = 0.0, high = degrees;
  while (ChiSquareTail(high, degrees) > 1.0 - probability) low = high, high *= 2.0;
  while (high - low > 1e-12 * high) {
    const double middle = 0.5 * (low + high);
    (ChiSquareTail(middle, degrees) > 1.0 - probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace planegraph
