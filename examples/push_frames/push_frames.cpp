// Pushes frames into pavo and prints the poses: a camera that walks up to a wall of random dots, ten frames long.
//
//   cmake -S examples/push_frames -B build/example -DCMAKE_PREFIX_PATH=/where/pavo/was/installed
//   cmake --build build/example && build/example/push_frames
#include <cstdint>
#include <cstdio>
#include <random>
#include <vector>

#include "pavo/visual_odometry.h"

int main() {
  const pavo::Camera camera{.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 319.5, .cy = 239.5};

  struct Dot {
    double x, y, z;
    std::uint8_t gray;
  };
  std::mt19937 random(1);
  std::uniform_real_distribution<double> across(-8, 8), away(6, 14), brightness(0, 255);
  std::vector<Dot> dots(1500);
  for (Dot& dot : dots)
    dot = {across(random), across(random), away(random), static_cast<std::uint8_t>(brightness(random))};

  pavo::VisualOdometry odometry(camera, {}, [](const pavo::PoseEstimate& pose) {
    std::printf("frame %ld: %s at (%.2f, %.2f, %.2f), %d inliers\n", static_cast<long>(pose.frame),
                pose.quality.c_str(), pose.T_world_camera[3], pose.T_world_camera[7], pose.T_world_camera[11],
                pose.inliers);
  });

  std::vector<std::uint8_t> image(static_cast<std::size_t>(camera.width) * camera.height);
  for (int k = 0; k < 10; ++k) {
    image.assign(image.size(), 128);
    for (const Dot& dot : dots) {
      const double z = dot.z - 0.2 * k;  // the camera has moved 0.2 forward with every frame
      const int u = static_cast<int>(camera.fx * dot.x / z + camera.cx),
                v = static_cast<int>(camera.fy * dot.y / z + camera.cy);
      for (int y = v; y < v + 5; ++y)
        for (int x = u; x < u + 5; ++x)
          if (x >= 0 && x < camera.width && y >= 0 && y < camera.height)
            image[static_cast<std::size_t>(y) * camera.width + x] = dot.gray;
    }
    odometry.push(image.data(), camera.width, k * 100'000'000L);
  }
  odometry.finish();
}
