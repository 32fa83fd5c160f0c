#pragma once
#include <gmock/gmock.h>

#include "app/program.h"
#include "support/json_schema.h"

namespace mimbre::app_test {

/// What a command answered with --json is what schema/output.schema.json says.
inline void expect_schema(const std::string& answer) {
  static const std::string schema = read_file(fs::path(MIMBRE_SOURCE_DIR) / "schema/output.schema.json");
  EXPECT_THAT(test::schema_violations(answer, schema), ::testing::IsEmpty());
}

}  // namespace mimbre::app_test
