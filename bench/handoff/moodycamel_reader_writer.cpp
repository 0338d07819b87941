#include <readerwriterqueue/readerwriterqueue.h>

#include "bench/handoff/competitors.h"

namespace pavo::bench {
namespace {

class Theirs final : public Handoff {
 public:
  void put(int token) override { queue_.enqueue(token); }
  int take() override {
    int token = 0;
    queue_.wait_dequeue(token);
    return token;
  }

 private:
  moodycamel::BlockingReaderWriterQueue<int> queue_{kTokens};
};

}  // namespace

std::unique_ptr<Handoff> moodycamel_reader_writer() {
  return std::make_unique<Theirs>();
}

}  // namespace pavo::bench
