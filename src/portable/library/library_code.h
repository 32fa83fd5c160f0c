#pragma once
#include <map>
#include <memory>
#include <span>
#include <string>

#include "mimbre/generate.h"

/// FMUs with the library inside, in place of code for one model.
namespace mimbre::portable {

/// C99 with the interface of generated code (docs/generated-code.md), which calls the library's runtime
/// (runtime.h). It has the model as bytes. The method is that of a run with these options, whatever
/// formulation, formalism or integrator; outputs are all of the model's. Parameters are those of the model's
/// file or text, where it was read from one with these `settings`. Throws InputError for laws and blocks that
/// are code from elsewhere, and where the start cannot be found.
GeneratedCode library_code(const std::shared_ptr<const Model>& model, const RunOptions& options,
                           const std::string& name, const std::map<std::string, std::string>& settings);

/// The runtime as a shared library, which the build compiles in (cmake/EmbedRuntime.cmake); none where it
/// cannot.
std::span<const unsigned char> runtime_bytes();

}  // namespace mimbre::portable
