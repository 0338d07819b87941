#include "bench/detectors/pictures.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "bench/detectors/competitor.h"

namespace pavo::bench {
namespace {

constexpr int kTileWidth = 640, kTitleHeight = 22, kGap = 6;
constexpr double kDarkened = 0.55;

void draw(cv::Mat& canvas, const PointPair& pair, const cv::Scalar& colour) {
  constexpr int kBits = 4;  // of OpenCV's fractions of a pixel
  const auto fixed = [](float v) { return cv::saturate_cast<int>(v * (1 << kBits)); };
  const cv::Point from(fixed(pair.x_previous), fixed(pair.y_previous)),
      to(fixed(pair.x_current), fixed(pair.y_current));
  cv::line(canvas, from, to, colour, 2, cv::LINE_AA, kBits);
  cv::circle(canvas, to, 2 << kBits, colour, cv::FILLED, cv::LINE_AA, kBits);
}

}  // namespace

cv::Mat draw_matches(const Image& current, const PointPairs& pairs, std::span<const std::uint8_t> right) {
  cv::Mat canvas;
  cv::cvtColor(mat_of(current) * kDarkened, canvas, cv::COLOR_GRAY2BGR);
  for (const bool now : {true, false})
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if ((right[i] != 0) == now) draw(canvas, pairs[i], now ? cv::Scalar(80, 220, 60) : cv::Scalar(50, 50, 255));
  return canvas;
}

cv::Mat contact_sheet(const std::vector<Tile>& tiles) {
  constexpr int kColumns = 2;
  if (tiles.empty()) return {};
  const cv::Size first = tiles.front().picture.size();
  const int height = kTileWidth * first.height / first.width, step = height + kTitleHeight + kGap;
  const int rows = (static_cast<int>(tiles.size()) + kColumns - 1) / kColumns;
  cv::Mat sheet(rows * step, kColumns * (kTileWidth + kGap) - kGap, CV_8UC3, cv::Scalar::all(255));
  for (int i = 0; i < static_cast<int>(tiles.size()); ++i) {
    const Tile& tile = tiles[static_cast<std::size_t>(i)];
    const cv::Point corner(i % kColumns * (kTileWidth + kGap), i / kColumns * step);
    cv::putText(sheet, tile.title, corner + cv::Point(2, kTitleHeight - 6), cv::FONT_HERSHEY_SIMPLEX, 0.48,
                cv::Scalar::all(0), 1, cv::LINE_AA);
    cv::Mat place = sheet(cv::Rect(corner.x, corner.y + kTitleHeight, kTileWidth, height));
    cv::resize(tile.picture, place, place.size(), 0, 0, cv::INTER_AREA);
  }
  return sheet;
}

void write_picture(const std::string& path, const cv::Mat& picture) {
  bool written = false;
  try {
    written = cv::imwrite(path, picture, {cv::IMWRITE_JPEG_QUALITY, 74, cv::IMWRITE_JPEG_OPTIMIZE, 1});
  } catch (const cv::Exception&) {
  }
  if (!written) throw std::runtime_error(path + ": cannot be written; give --pictures a folder that can be");
}

}  // namespace pavo::bench
