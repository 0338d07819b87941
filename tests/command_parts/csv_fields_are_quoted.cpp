// What is written into a table's field is what is read back, and a record is one line.
#include <gtest/gtest.h>

#include "tools/pavo/csv_field.h"

namespace pavo::test {
namespace {

TEST(CsvField, IsQuotedWhereItMustBe) {
  EXPECT_EQ(csv_field("000012.png"), "000012.png");
  EXPECT_EQ(csv_field(""), "");
  EXPECT_EQ(csv_field("a, b"), "\"a, b\"");
  EXPECT_EQ(csv_field("a \"b\""), "\"a \"\"b\"\"\"");
  EXPECT_EQ(csv_field("one\nline\r\nonly, please"), "\"one line  only, please\"");
}

}  // namespace
}  // namespace pavo::test
