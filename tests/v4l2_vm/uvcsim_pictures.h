// What the simulated webcam can send, and the pictures that it sends.
#pragma once

#include <turbojpeg.h>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

using bytes = std::vector<uint8_t>;
struct Size {
  int w, h;
};
inline const Size kSizes[] = {{640, 480}, {320, 240}, {1280, 720}};
struct Format {
  const char* fourcc;
  int bpp;
};
inline const Format kFormats[] = {{"YUY2", 2}, {"Y800", 1}, {"MJPG", 2}};  // bytes a pixel: of MJPG the most
inline bool is_jpeg(const Format& f) {
  return f.fourcc[0] == 'M';
}
inline bytes whole_file(const char* name) {
  std::ifstream file(name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}
// The pixels of a PGM of this size; none where it is something else.
inline bytes gray_of(const bytes& file, const Size& z) {
  int w = 0, h = 0, most = 0, head = 0;
  const std::string start(file.begin(), file.begin() + std::min<size_t>(file.size(), 64));
  if (sscanf(start.c_str(), "P5 %d %d %d%n", &w, &h, &most, &head) != 3 || w != z.w || h != z.h) return {};
  if (file.size() < size_t(head) + 1 + size_t(w) * h) return {};
  return {file.begin() + head + 1, file.begin() + head + 1 + w * h};
}
inline bytes jpeg_of(const bytes& gray, const Size& z) {
  static const tjhandle tj = tjInitCompress();
  unsigned char* out = nullptr;
  unsigned long n = 0;
  bytes jpeg;
  if (!tjCompress2(tj, gray.data(), z.w, 0, z.h, TJPF_GRAY, &out, &n, TJSAMP_GRAY, 95, 0)) jpeg.assign(out, out + n);
  tjFree(out);
  return jpeg;
}
// One frame as it is sent; `even`: the brightness where nothing else is given.
inline bytes picture(const Format& f, const Size& z, uint8_t even) {
  const char* name = getenv("UVCSIM_PICTURE");
  const bytes file = name ? whole_file(name) : bytes();
  bytes gray = gray_of(file, z);
  if (is_jpeg(f) && gray.empty() && !file.empty()) return file;
  if (gray.empty()) gray.assign(size_t(z.w) * z.h, even);
  if (is_jpeg(f)) return jpeg_of(gray, z);
  if (f.bpp == 1) return gray;
  bytes yuyv(2 * gray.size(), 128);
  for (size_t i = 0; i < gray.size(); ++i) yuyv[2 * i] = gray[i];
  return yuyv;
}
