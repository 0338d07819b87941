#include "stages/people/linear_svm.h"

#include <linear.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

namespace pavo {

struct SvmSamples::Nodes : feature_node {};

SvmSamples::SvmSamples(std::size_t dimensions) : dimensions_(dimensions) {}

SvmSamples::~SvmSamples() {
  for (Nodes* n : nodes_) delete[] n;
}

void SvmSamples::add(std::span<const float> descriptor, bool positive) {
  if (descriptor.size() != dimensions_) throw std::invalid_argument("svm: a sample of another size");
  auto nodes = std::make_unique<Nodes[]>(dimensions_ + 2);
  int index = 0;
  Nodes* node = nodes.get();
  for (const float value : descriptor) {
    ++index;
    if (value == 0) continue;
    node->index = index;
    (node++)->value = static_cast<double>(value);
  }
  node->index = index + 1;  // the bias
  (node++)->value = 1;
  node->index = -1;
  nodes_.push_back(nodes.get());
  nodes.release();
  labels_.push_back(positive ? 1 : -1);
}

void SvmSamples::keep_only(std::span<const char> keep) {
  std::size_t to = 0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (!keep[i]) {
      delete[] nodes_[i];
      continue;
    }
    nodes_[to] = nodes_[i];
    labels_[to++] = labels_[i];
  }
  nodes_.resize(to);
  labels_.resize(to);
}

std::size_t SvmSamples::size() const {
  return nodes_.size();
}

bool SvmSamples::positive(std::size_t i) const {
  return labels_[i] > 0;
}

double SvmSamples::margin(std::size_t i, std::span<const double> weights_and_bias) const {
  double sum = 0;
  for (const Nodes* n = nodes_[i]; n->index != -1; ++n)
    sum += n->value * weights_and_bias[static_cast<std::size_t>(n->index - 1)];
  return sum;
}

std::vector<double> fit_linear_svm(const SvmSamples& samples, double C, double positive_weight, double tolerance,
                                   std::span<const double> start) {
  const auto positives = std::count(samples.labels_.begin(), samples.labels_.end(), 1.0);
  if (positives == 0 || positives == static_cast<std::ptrdiff_t>(samples.size()))
    throw std::invalid_argument("svm: needs samples of both classes");
  std::vector<feature_node*> rows(samples.nodes_.begin(), samples.nodes_.end());
  std::vector<double> labels = samples.labels_;
  problem problem{};
  problem.l = static_cast<int>(rows.size());
  problem.n = static_cast<int>(samples.dimensions_) + 1;
  problem.x = rows.data();
  problem.y = labels.data();
  problem.bias = 1;  // the last dimension, as added to each sample

  int label[] = {1};
  double weight[] = {positive_weight};
  parameter parameter{};
  parameter.solver_type = L2R_L2LOSS_SVC;
  parameter.C = C;
  parameter.eps = tolerance;
  parameter.nr_weight = 1;
  parameter.weight_label = label;
  parameter.weight = weight;
  std::vector<double> begin(start.begin(), start.end());
  if (!begin.empty()) parameter.init_sol = begin.data();
  if (const char* error = check_parameter(&problem, &parameter)) throw std::invalid_argument(error);

  set_print_string_function([](const char*) {});
  struct Free {
    void operator()(model* m) const { free_and_destroy_model(&m); }
  };
  const std::unique_ptr<model, Free> trained(::train(&problem, &parameter));
  std::vector<double> result(trained->w, trained->w + problem.n);
  if (trained->label[0] != 1) throw std::logic_error("svm: liblinear orders the classes -1, +1 the other way round");
  return result;
}

}  // namespace pavo
