# The libraries that pavo stands on. tools/packages.txt names the Debian package of each.

find_package(Threads REQUIRED)
find_package(OpenCV 4.5 REQUIRED COMPONENTS core imgproc imgcodecs videoio calib3d features2d video objdetect)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(hwy REQUIRED IMPORTED_TARGET libhwy)
pkg_check_modules(turbojpeg REQUIRED IMPORTED_TARGET libturbojpeg)
pkg_check_modules(yaml_cpp REQUIRED IMPORTED_TARGET yaml-cpp)
find_path(CONCURRENTQUEUE_INCLUDE_DIR concurrentqueue/concurrentqueue.h REQUIRED)
find_path(TOMLPLUSPLUS_INCLUDE_DIR toml++/toml.h REQUIRED)
find_path(CLI11_INCLUDE_DIR CLI/CLI.hpp REQUIRED)

# OpenCV's headers flood a C++20 build with warnings; as SYSTEM they keep them to themselves.
add_library(pavo_opencv INTERFACE)
target_include_directories(pavo_opencv SYSTEM INTERFACE ${OpenCV_INCLUDE_DIRS})
target_link_libraries(pavo_opencv INTERFACE ${OpenCV_LIBS})

if(PAVO_BUILD_TESTS)
  find_package(GTest REQUIRED)
  find_package(Ceres REQUIRED)  # what our bundle adjustment is compared with
  include(GoogleTest)
endif()
if(PAVO_BUILD_BENCHMARKS)
  find_package(benchmark REQUIRED)
  find_path(READERWRITERQUEUE_INCLUDE_DIR readerwriterqueue/readerwriterqueue.h REQUIRED)
  find_path(BOOST_LOCKFREE_INCLUDE_DIR boost/lockfree/spsc_queue.hpp REQUIRED)
endif()
