// A linear support vector machine, by liblinear.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace pavo {

/// Samples as liblinear reads them: a node per number, so 16 bytes for each of a descriptor's 3780 numbers.
class SvmSamples {
 public:
  explicit SvmSamples(std::size_t dimensions);
  ~SvmSamples();
  SvmSamples(const SvmSamples&) = delete;
  SvmSamples& operator=(const SvmSamples&) = delete;

  void add(std::span<const float> descriptor, bool positive);
  /// Keeps the samples for which `keep` is not 0; their order stays.
  void keep_only(std::span<const char> keep);
  std::size_t size() const;
  bool positive(std::size_t i) const;
  /// weights . sample i + bias
  double margin(std::size_t i, std::span<const double> weights_and_bias) const;

 private:
  friend std::vector<double> fit_linear_svm(const SvmSamples&, double, double, double, std::span<const double>);
  struct Nodes;
  std::vector<Nodes*> nodes_;
  std::vector<double> labels_;
  std::size_t dimensions_;
};

/// min over w, b of 1/2 (|w|^2 + b^2) + C sum_i max(0, 1 - y_i (w . x_i + b))^2, the positives' terms times
/// `positive_weight`: liblinear's L2-regularised L2-loss machine, solved in the primal by a trust region Newton method
/// (Lin, Weng and Keerthi, JMLR 2008), which uses no random numbers: the same samples give the same result. `start` is
/// empty or where to begin. Returns the weights and, last, the bias. Throws std::invalid_argument without samples of
/// both classes.
std::vector<double> fit_linear_svm(const SvmSamples& samples, double C, double positive_weight, double tolerance,
                                   std::span<const double> start);

}  // namespace pavo
