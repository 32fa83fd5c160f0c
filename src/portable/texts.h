#pragma once

/// Parts of the code that are the same for every model, with '@' for its name:
/// tables_text.cpp, integrator_text.cpp, exchange_text.cpp.
namespace mimbre::portable {

extern const char* const functions_text;  ///< functions of one variable
extern const char* const formulas_text;   ///< integrals of formulas
extern const char* const roads_text;      ///< heights over a place
extern const char* const meshes_text;     ///< nearest points on triangles
extern const char* const table_of_two_text;
extern const char* const noise_text;       ///< random numbers
extern const char* const linear_text;      ///< factorisation and solution
extern const char* const finite_text;      ///< whether numbers are finite
extern const char* const integrator_text;  ///< a step
extern const char* const interface_text;   ///< what hosts call

// How outputs vary while the motion does not.
extern const char* const variations_text;
extern const char* const variations_at_rest_header_text;

// Of model exchange.
extern const char* const exchange_text;  ///< derivatives of the state by time, and the functions for hosts
extern const char* const exchange_header_text;    ///< the functions that hosts call
extern const char* const variations_header_text;  ///< those of directional derivatives

}  // namespace mimbre::portable
