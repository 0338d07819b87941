#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "drivers/models/model_file.h"

namespace pavo {
namespace {

constexpr std::string_view kMagic = "pavo-pedestrian-model";
constexpr int kVersion = 1;
constexpr std::string_view kBlanks = " \t\r\v\f";
constexpr std::size_t kPerLine = 36;
constexpr int kBlocksX = 7, kBlocksY = 15, kBins = 9;

std::string quoted(std::string_view token) {
  std::string text = "'";
  for (const char c : token.substr(0, 24)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (token.size() > 24 ? "...'" : "'");
}

/// The words of a text, line by line, and where they are.
class Words {
 public:
  Words(std::string_view text, const std::string& name) : rest_(text), name_(name) {}

  [[noreturn]] void fail(const std::string& message) const {
    throw std::runtime_error(name_ + ":" + std::to_string(line_number_) + ": " + message);
  }

  /// Goes to the next line that is neither blank nor a comment; false at the end.
  bool next_line() {
    while (!rest_.empty()) {
      const std::size_t end = rest_.find('\n');
      line_ = rest_.substr(0, end);
      rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
      ++line_number_;
      const std::size_t first = line_.find_first_not_of(kBlanks);
      if (first != std::string_view::npos && line_[first] != '#') return true;
    }
    line_ = {};
    return false;
  }

  /// The next word of this line, or nothing.
  std::string_view word() {
    const std::size_t begin = std::min(line_.find_first_not_of(kBlanks), line_.size());
    const std::size_t end = std::min(line_.find_first_of(kBlanks, begin), line_.size());
    const std::string_view w = line_.substr(begin, end - begin);
    line_.remove_prefix(end);
    return w;
  }

  /// A line that begins with `key`.
  void expect_line(std::string_view key) {
    if (!next_line()) fail("the file ends where '" + std::string(key) + "' was expected: it is not whole");
    if (const auto w = word(); w != key) fail("expected '" + std::string(key) + "', found " + quoted(w));
  }

  template <typename Real>
  Real number(std::string_view what) {
    const std::string_view w = word();
    if (w.empty()) fail("expected a number (" + std::string(what) + "), found the end of the line");
    return number_of<Real>(w);
  }

  template <typename Real>
  Real number_of(std::string_view w) const {
    const std::string copy(w);  // libstdc++'s from_chars looks for a zero behind "nan"
    Real value = 0;
    const auto [end, error] = std::from_chars(copy.data(), copy.data() + copy.size(), value);
    if (error == std::errc::result_out_of_range) fail(quoted(w) + " is out of range");
    if (error != std::errc{} || end != copy.data() + copy.size()) fail("expected a number, found " + quoted(w));
    if (!std::isfinite(value)) fail("expected a finite number, found " + quoted(w));
    return value;
  }

  void end_of_line() {
    if (const auto w = word(); !w.empty()) fail("unexpected " + quoted(w) + " at the end of the line");
  }

  template <typename Real>
  Real only_number(std::string_view key) {
    expect_line(key);
    const Real value = number<Real>(key);
    end_of_line();
    return value;
  }

 private:
  std::string_view rest_, line_;
  const std::string& name_;
  std::size_t line_number_ = 0;
};

HogTone read_tone(Words& words) {
  words.expect_line("tone");
  const std::string_view tone = words.word();
  if (tone != "linear" && tone != "square_root") words.fail("expected linear or square_root, found " + quoted(tone));
  words.end_of_line();
  return tone == "linear" ? HogTone::linear : HogTone::square_root;
}

void read_version(Words& words) {
  words.next_line();
  words.word();  // the magic word
  const std::string_view version = words.word();
  if (version != std::to_string(kVersion))
    words.fail("the model is of version " + quoted(version) + ", this pavo reads version " + std::to_string(kVersion) +
               ": train it anew, or use the pavo that made it");
  words.end_of_line();
}

PedestrianModel parse_own(std::string_view text, const std::string& name) {
  Words words(text, name);
  PedestrianModel model;
  read_version(words);
  model.features.tone = read_tone(words);
  model.features.epsilon = words.only_number<float>("epsilon");
  if (!(model.features.epsilon > 0)) words.fail("epsilon must be positive");
  model.features.clip = words.only_number<float>("clip");
  if (!(model.features.clip > 0)) words.fail("clip must be positive");
  model.features.fade = words.only_number<float>("fade");
  if (!(model.features.fade > 0)) words.fail("fade must be positive");
  words.expect_line("calibration");
  model.slope = words.number<double>("slope");
  model.offset = words.number<double>("offset");
  words.end_of_line();
  if (!(model.slope > 0)) words.fail("the slope of the calibration must be positive");
  model.threshold = words.only_number<float>("threshold");
  if (!(model.threshold >= 0 && model.threshold <= 1)) words.fail("the threshold is a probability, from 0 to 1");
  model.bias = words.only_number<float>("bias");
  if (words.only_number<double>("weights") != static_cast<double>(PedestrianModel::kWeights))
    words.fail("expected 3780 weights");
  model.weights.reserve(PedestrianModel::kWeights);
  while (model.weights.size() < PedestrianModel::kWeights) {
    if (!words.next_line())
      words.fail("the file ends after " + std::to_string(model.weights.size()) + " of 3780 weights: it is not whole");
    for (std::size_t i = 0; i < kPerLine; ++i) model.weights.push_back(words.number<float>("36 weights a line"));
    words.end_of_line();
  }
  words.expect_line("end");
  words.end_of_line();
  if (words.next_line()) words.fail("unexpected text behind the end");
  return model;
}

/// OpenCV's order: blocks by columns, in a block cells by columns.
PedestrianModel from_opencv(const std::vector<float>& numbers) {
  PedestrianModel model;
  model.weights.resize(PedestrianModel::kWeights);
  std::size_t from = 0;
  for (int bx = 0; bx < kBlocksX; ++bx)
    for (int by = 0; by < kBlocksY; ++by)
      for (int cell_x = 0; cell_x < 2; ++cell_x)
        for (int cell_y = 0; cell_y < 2; ++cell_y)
          for (int bin = 0; bin < kBins; ++bin) {
            const int to = (((by * kBlocksX + bx) * 2 + cell_y) * 2 + cell_x) * kBins + bin;
            model.weights[static_cast<std::size_t>(to)] = numbers[from++];
          }
  if (from < numbers.size()) model.bias = numbers[from];
  model.features = {HogTone::square_root, 100, 0.2f, 0.001f};
  return model;
}

PedestrianModel parse_opencv(std::string_view text, const std::string& name) {
  std::string plain(text);
  std::replace_if(
      plain.begin(), plain.end(), [](char c) { return c == ',' || c == ';' || c == '[' || c == ']'; }, ' ');
  Words words(plain, name);
  std::vector<float> numbers;
  while (words.next_line())
    for (std::string_view w = words.word(); !w.empty(); w = words.word()) {
      if (numbers.empty() && w.find_first_not_of("+-.0123456789eE") != std::string_view::npos)
        words.fail("neither a pavo model (its first line is '" + std::string(kMagic) + " " + std::to_string(kVersion) +
                   "') nor the numbers of an OpenCV people detector");
      if (numbers.size() > PedestrianModel::kWeights)
        words.fail("more than the 3781 numbers of a 64x128 people detector");
      numbers.push_back(words.number_of<float>(w));
    }
  if (numbers.empty()) words.fail("the file is empty: expected a pavo model");
  if (numbers.size() < PedestrianModel::kWeights)
    words.fail("the file ends after " + std::to_string(numbers.size()) +
               " numbers: expected 3780, or 3781 with the bias");
  return from_opencv(numbers);
}

template <typename Real>
void append(std::string& text, Real value) {
  char digits[40];
  text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

}  // namespace

PedestrianModel parse_pedestrian_model(std::string_view text, const std::string& name) {
  if (Words first(text, name); first.next_line() && first.word() == kMagic) return parse_own(text, name);
  return parse_opencv(text, name);
}

std::string pedestrian_model_text(const PedestrianModel& model, std::string_view comment) {
  if (model.weights.size() != PedestrianModel::kWeights) throw std::invalid_argument("a model has 3780 weights");
  std::string text = std::string(kMagic) + " " + std::to_string(kVersion) + "\n";
  while (!comment.empty()) {
    const std::size_t end = std::min(comment.find('\n'), comment.size());
    text += "# " + std::string(comment.substr(0, end)) + "\n";
    comment.remove_prefix(std::min(end + 1, comment.size()));
  }
  const auto line = [&](std::string_view key, auto... values) {
    text += key;
    ((text += ' ', append(text, values)), ...);
    text += '\n';
  };
  text += model.features.tone == HogTone::linear ? "tone linear\n" : "tone square_root\n";
  line("epsilon", model.features.epsilon);
  line("clip", model.features.clip);
  line("fade", model.features.fade);
  line("calibration", model.slope, model.offset);
  line("threshold", model.threshold);
  line("bias", model.bias);
  line("weights", PedestrianModel::kWeights);
  for (std::size_t i = 0; i < model.weights.size(); ++i) {
    append(text, model.weights[i]);
    text += (i + 1) % kPerLine == 0 ? '\n' : ' ';
  }
  return text + "end\n";
}

}  // namespace pavo
