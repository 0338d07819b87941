// SHA-256 against the examples of FIPS 180-4, in any pieces.
#include "drivers/trajectories/sha256.h"

#include <gmock/gmock.h>

#include "tests/support/temporary.h"

namespace pavo {
namespace {

std::string sha256(std::string_view bytes) {
  Sha256 sum;
  sum.update(bytes);
  return sum.hex();
}

TEST(Sha256, GivesThePublishedDigests) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1'000'000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, DoesNotDependOnThePieces) {
  Sha256 sum;
  for (const char* piece : {"ab", "", "c"}) sum.update(piece);
  EXPECT_EQ(sum.hex(), sha256("abc"));
  sum.update("d");
  EXPECT_EQ(sum.hex(), sha256("abcd")) << "goes on after hex()";
}

TEST(Sha256, OfAFileIsThatOfItsBytes) {
  const test::TemporaryFolder folder;
  const std::string bytes(150'000, 'x');
  EXPECT_EQ(sha256_of_file(folder.write("a", bytes)), sha256(bytes));
  EXPECT_EQ(sha256_of_file(folder.write("b", "")), sha256(""));
  EXPECT_THAT(test::complaint([&] { sha256_of_file(folder.file("none")); }),
              ::testing::HasSubstr("none: cannot be read: No such file"));
  EXPECT_THAT(test::complaint([&] { sha256_of_file(folder.file("")); }), ::testing::HasSubstr("cannot be read"));
}

}  // namespace
}  // namespace pavo
