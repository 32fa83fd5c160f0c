#pragma once
#include <memory>
#include <string>

#include "mimbre/model.h"

namespace mimbre {

/// One HTML file that simulates the model: the solver as WebAssembly, the model (model_bytes), and the live
/// page. It opens from a folder, and needs no server, network or installation. `wasm`: a file
/// with the solver in place of the one that was built in. Throws InputError where the model cannot be written
/// (model_bytes), std::runtime_error where mimbre was built without its pages or the solver, with how to
/// build them.
std::string page_html(const std::shared_ptr<const Model>& model, const std::string& wasm = "");

/// The same as a file. Throws std::runtime_error when it cannot be written; an older file then stays as it
/// was.
void write_page(const std::shared_ptr<const Model>& model, const std::string& path,
                const std::string& wasm = "");

/// Whether the solver of pages was built in.
bool has_page_solver();

}  // namespace mimbre
