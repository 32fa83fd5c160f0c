#include "spec/output_words.h"

#include <fmt/format.h>

namespace mimbre {

std::string kinds_with(bool (*uses)(const OutputInfo&)) {
  std::string text;
  for (const OutputInfo* info : all_outputs())
    if (info->in_files && uses(*info)) text += fmt::format("{}'{}'", text.empty() ? "" : " and ", info->name);
  return text;
}

}  // namespace mimbre
