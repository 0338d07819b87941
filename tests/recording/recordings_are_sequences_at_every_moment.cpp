// What is recorded is read back in order, whoever was slow, whatever failed, wherever it was cut off.
#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <latch>
#include <semaphore>
#include <thread>

#include "drivers/recording/encode_png.h"
#include "drivers/recording/sequence_recorder.h"
#include "drivers/sequences/sequence.h"
#include "tests/support/temporary.h"

namespace pavo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

constexpr int kWidth = 16, kHeight = 8;
constexpr std::int64_t kPeriod = 33'333'333, kStart = 1'403'636'579'763'555'584;

/// A frame that knows its number.
EncodedImage frame_of(int number) {
  EncodedImage frame{.encoding = Encoding::gray8, .width = kWidth, .height = kHeight, .stride = kWidth};
  frame.bytes.assign(kWidth * kHeight, static_cast<std::uint8_t>(number));
  return frame;
}

std::string_view encode_gray(const EncodedImage& frame, std::vector<std::uint8_t>& file) {
  const std::string header = "P5\n16 8\n255\n";
  file.assign(header.begin(), header.end());
  file.insert(file.end(), frame.bytes.begin(), frame.bytes.end());
  return ".pgm";
}

struct ReadFrame {
  int number;
  std::int64_t t_ns;
};

std::vector<ReadFrame> read_back(const std::string& folder) {
  const auto sequence = open_sequence(folder);
  std::vector<ReadFrame> frames;
  EncodedImage image;
  FrameStamp stamp;
  while (sequence->read(image, stamp)) {
    EXPECT_EQ(image.bytes.size(), std::string("P5\n16 8\n255\n").size() + kWidth * kHeight) << stamp.name;
    frames.push_back({image.bytes.back(), stamp.t_capture_ns});
  }
  return frames;
}

class Recordings : public ::testing::TestWithParam<RecordLayout> {
 protected:
  RecorderOptions options(bool wait = true) const {
    RecorderOptions o{.layout = GetParam(), .encoders = 3, .waiting = 5, .wait_for_room = wait};
    return o;
  }
  std::string path() const { return folder.file("drive"); }
  TemporaryFolder folder;
};

TEST_P(Recordings, HoldEveryFrameWithItsTime) {
  constexpr int kFrames = 100;
  SequenceRecorder recorder(path(), options(), [] {
    return [n = 0](const EncodedImage& frame, std::vector<std::uint8_t>& file) mutable {
      if (++n % 7 == 0) std::this_thread::yield();  // out of order
      return encode_gray(frame, file);
    };
  });
  for (int i = 0; i < kFrames; ++i) {
    EncodedImage frame = frame_of(i);
    EXPECT_TRUE(recorder.offer(frame, kStart + i * kPeriod));
  }
  recorder.finish();
  EXPECT_EQ(recorder.counts().written, static_cast<std::uint64_t>(kFrames));
  const auto frames = read_back(path());
  ASSERT_EQ(frames.size(), static_cast<std::size_t>(kFrames));
  for (int i = 0; i < kFrames; ++i) {
    EXPECT_EQ(frames[static_cast<std::size_t>(i)].number, i);
    EXPECT_EQ(frames[static_cast<std::size_t>(i)].t_ns, kStart + i * kPeriod);
  }
}

// The camera is never kept waiting: what finds no place is counted.
TEST_P(Recordings, NeverDelayWhoeverOffersFrames) {
  std::counting_semaphore<> allowed(0);
  SequenceRecorder recorder(path(), options(false), [&] {
    return [&](const EncodedImage& frame, std::vector<std::uint8_t>& file) {
      allowed.acquire();
      return encode_gray(frame, file);
    };
  });
  int taken = 0;
  for (int i = 0; i < 20; ++i) {
    EncodedImage frame = frame_of(i);
    taken += recorder.offer(frame, kStart + i * kPeriod);
  }
  EXPECT_EQ(taken, 8);  // 3 in the encoders' hands (or about to be), 5 waiting
  EXPECT_EQ(recorder.counts().no_room, 12u);
  allowed.release(100);
  recorder.finish();
  const auto frames = read_back(path());
  ASSERT_EQ(frames.size(), 8u);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(frames[static_cast<std::size_t>(i)].t_ns, kStart + i * kPeriod);
}

TEST_P(Recordings, LeaveOutWhatCannotBeEncoded) {
  SequenceRecorder recorder(path(), options(), [] {
    return [](const EncodedImage& frame, std::vector<std::uint8_t>& file) {
      if (frame.bytes.front() % 5 == 3) throw std::runtime_error("a bad frame");
      return encode_gray(frame, file);
    };
  });
  for (int i = 0; i < 20; ++i) {
    EncodedImage frame = frame_of(i);
    recorder.offer(frame, kStart + i * kPeriod);
  }
  recorder.finish();
  EXPECT_EQ(recorder.counts().failed, 4u);
  EXPECT_EQ(recorder.counts().written, 16u);
  EXPECT_EQ(recorder.first_failure(), "a bad frame");
  const auto frames = read_back(path());
  ASSERT_EQ(frames.size(), 16u);
  for (const ReadFrame& frame : frames) {
    EXPECT_NE(frame.number % 5, 3);
    EXPECT_EQ(frame.t_ns, kStart + frame.number * kPeriod);
  }
}

TEST_P(Recordings, EndWhereNothingCanBeWrittenAnyMore) {
  const bool euroc = GetParam() == RecordLayout::euroc;
  const fs::path images = fs::path(path()) / (euroc ? "mav0/cam0/data" : "image_0");
  SequenceRecorder recorder(path(), options(), [] { return encode_gray; });
  int i = 0;
  for (; i < 10; ++i) {
    EncodedImage frame = frame_of(i);
    recorder.offer(frame, kStart + i * kPeriod);
  }
  while (recorder.counts().written < 10) std::this_thread::yield();
  fs::rename(images, images.string() + ".gone");
  for (; i < 1000 && !recorder.failed(); ++i) {
    EncodedImage frame = frame_of(i);
    recorder.offer(frame, kStart + i * kPeriod);
  }
  EncodedImage late = frame_of(i);
  EXPECT_FALSE(recorder.offer(late, kStart + i * kPeriod));
  EXPECT_THAT(complaint([&] { recorder.finish(); }), HasSubstr("cannot be written: No such file"));
  EXPECT_EQ(recorder.counts().offered, recorder.counts().written + recorder.counts().no_room);
  fs::rename(images.string() + ".gone", images);
  EXPECT_EQ(read_back(path()).size(), 10u) << "everything before is there";
}

// A killed process leaves what is on the disk at that moment: the folder is copied while it is written.
TEST_P(Recordings, CanBeReadAtAnyMoment) {
  SequenceRecorder recorder(path(), options(), [] { return encode_gray; });
  for (int i = 0; i < 60; ++i) {
    EncodedImage frame = frame_of(i);
    recorder.offer(frame, kStart + i * kPeriod);
    if (i % 10 != 9) continue;
    while (recorder.counts().written == 0) std::this_thread::yield();
    const std::string copy = folder.file("copy" + std::to_string(i));
    // The images first: an index that is copied later names more than there is, which a kill cannot bring about, so
    // the index is taken first where it is the one that must not run ahead.
    fs::create_directories(copy);
    const bool euroc = GetParam() == RecordLayout::euroc;
    const fs::path base = fs::path(path()) / (euroc ? "mav0/cam0" : "."),
                   to = fs::path(copy) / (euroc ? "mav0/cam0" : ".");
    fs::create_directories(to);
    const auto copy_index = [&] {
      const char* name = euroc ? "data.csv" : "times.txt";
      fs::copy_file(base / name, to / name);
    };
    const auto copy_images = [&] {
      const char* name = euroc ? "data" : "image_0";
      fs::create_directory(to / name);
      for (const auto& entry : fs::directory_iterator(base / name)) {
        std::error_code renamed_meanwhile;
        fs::copy_file(entry.path(), to / name / entry.path().filename(), renamed_meanwhile);
      }
    };
    if (euroc) {
      copy_index();
      copy_images();
    } else {
      copy_images();
      copy_index();
    }
    if (euroc && bytes_of((to / "data.csv").string()).find(".pgm") == std::string::npos) continue;
    for (const ReadFrame& read : read_back(copy)) EXPECT_EQ(read.t_ns, kStart + read.number * kPeriod);
  }
  recorder.finish();
}

TEST_P(Recordings, RefuseTimesThatDoNotIncreaseAndFoldersThatAreUsed) {
  {
    SequenceRecorder recorder(path(), options(), [] { return encode_gray; });
    EncodedImage frame = frame_of(0);
    recorder.offer(frame, kStart);
    EXPECT_THAT(complaint([&] { recorder.offer(frame, kStart); }), HasSubstr("not later"));
  }
  const auto record_into = [&](const std::string& where) {
    return complaint([&] { SequenceRecorder(where, options(), [] { return encode_gray; }); });
  };
  EXPECT_THAT(record_into(path()), HasSubstr("is not empty"));
  EXPECT_THAT(record_into(folder.write("file", "x")), HasSubstr("cannot be made"));
}

INSTANTIATE_TEST_SUITE_P(Layouts, Recordings, ::testing::Values(RecordLayout::euroc, RecordLayout::kitti),
                         [](const auto& i) { return i.param == RecordLayout::euroc ? "Euroc" : "Kitti"; });

}  // namespace
}  // namespace pavo::test
