#include "tools/pavo/movie.h"

#include <fmt/format.h>

#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <stdexcept>

namespace pavo {

namespace {

// A frame that failed has no image.
void blacken(Image& image, int width, int height) {
  constexpr int kPaper = 32;
  image.resize(width, height);
  for (int y = 0; y < height; ++y) std::memset(image.row(y), kPaper, static_cast<std::size_t>(width));
}

}  // namespace

// Pictures in a folder, or a film.
class Movie::Writer {
 public:
  Writer(std::string where, double rate_hz) : where_(std::move(where)), rate_hz_(rate_hz) {
    const std::filesystem::path path(where_);
    std::string extension = path.extension();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    is_film_ = extension == ".mp4";
    for (const char* other : {".avi", ".mkv", ".mov", ".webm", ".mpg", ".m4v", ".gif"})
      if (extension == other) throw std::runtime_error("--draw " + where_ + ": expected a film in .mp4, or a folder");
    std::error_code error;
    const std::filesystem::path folder = is_film_ ? path.parent_path() : path;
    if (!folder.empty()) std::filesystem::create_directories(folder, error);
    if (error) throw std::runtime_error("--draw " + where_ + ": this folder cannot be made: " + error.message());
  }

  void write(const cv::Mat& picture, std::int64_t index) {
    if (is_film_)
      write_to_film(picture);
    else
      write_picture(picture, index);
  }

  /// A full disk does not stop FFmpeg, which tells nobody: only the finished film shows whether all is in it.
  void finish() {
    if (!film_.isOpened()) return;
    film_.release();
    cv::VideoCapture film(where_, cv::CAP_FFMPEG);
    if (!film.isOpened() || std::llround(film.get(cv::CAP_PROP_FRAME_COUNT)) < film_frames_)
      throw std::runtime_error("--draw: " + where_ + " is incomplete: not all of its " + std::to_string(film_frames_) +
                               " frames could be written; is the disk full?");
  }

 private:
  void write_picture(const cv::Mat& picture, std::int64_t index) {
    const std::string file = fmt::format("{}/{:06d}.jpg", where_, index);
    bool written = false;
    try {
      written = cv::imwrite(file, picture, {cv::IMWRITE_JPEG_QUALITY, 90});
    } catch (const cv::Exception&) {  // told below
    }
    if (!written) throw std::runtime_error("--draw: " + file + " cannot be written");
  }

  void write_to_film(const cv::Mat& picture) {
    if (!film_.isOpened()) {
      film_.open(where_, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), rate_hz_, picture.size());
      if (!film_.isOpened()) throw std::runtime_error("--draw: " + where_ + " cannot be written as a film");
    }
    film_.write(picture);
    ++film_frames_;
  }

  std::string where_;
  double rate_hz_;
  bool is_film_ = false;
  cv::VideoWriter film_;
  std::int64_t film_frames_ = 0;
};

Movie::Movie(const std::string& where, const Camera& camera, double rate_hz, bool wait_for_drawing)
    : writer_(std::make_unique<Writer>(where, rate_hz)),
      width_(camera.width),
      height_(camera.height),
      wait_for_drawing_(wait_for_drawing) {
  for (std::size_t i = 0; i < kMostWaiting; ++i) unused_.push_back(std::make_unique<FrameSnapshot>());
  thread_ = std::jthread([this](const std::stop_token& stop) { draw(stop); });
}

Movie::~Movie() = default;

void Movie::offer(const Frame& frame, const FrameInfo& info, const Outcome& outcome) {
  std::unique_ptr<FrameSnapshot> snapshot;
  {
    std::unique_lock lock(mutex_);
    if (wait_for_drawing_) changed_.wait(lock, [this] { return !unused_.empty() || error_; });
    if (error_) std::rethrow_exception(error_);
    if (unused_.empty()) {
      ++passed_by_;
      return;
    }
    snapshot = std::move(unused_.back());
    unused_.pop_back();
  }
  take_snapshot(frame, info.source_index, outcome.failed, *snapshot);
  if (snapshot->image.empty()) blacken(snapshot->image, width_, height_);
  const std::lock_guard lock(mutex_);
  waiting_.push_back(std::move(snapshot));
  changed_.notify_all();
}

void Movie::finish() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
  thread_.join();
  if (error_) std::rethrow_exception(error_);
  writer_->finish();
}

void Movie::draw(const std::stop_token& stop) {
  std::vector<Eigen::Vector3d> path;
  for (;;) {
    std::unique_ptr<FrameSnapshot> snapshot;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, stop, [this] { return !waiting_.empty() || ended_; });
      if (stop.stop_requested() || waiting_.empty()) return;
      snapshot = std::move(waiting_.front());
      waiting_.pop_front();
    }
    path.push_back(snapshot->pose.T_w_c.t);
    std::exception_ptr error;
    try {
      writer_->write(draw_frame(*snapshot, path), snapshot->index);
    } catch (...) {
      error = std::current_exception();
    }
    const std::lock_guard lock(mutex_);
    unused_.push_back(std::move(snapshot));
    changed_.notify_all();
    if (error) {
      error_ = error;
      return;
    }
  }
}

}  // namespace pavo
