#pragma once

#include <array>
#include <string_view>
#include <utility>

namespace roadbalance {

/// In every answer.  The page takes nothing from elsewhere, nothing inline, stands in nobody's frame and
/// makes no markup of text; and it is not kept.
inline constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kSafetyHeaders{
    {{"Content-Security-Policy",
      "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
      "base-uri 'none'; form-action 'none'; frame-ancestors 'none'; require-trusted-types-for 'script'; "
      "trusted-types 'none'"},
     {"X-Content-Type-Options", "nosniff"},
     {"X-Frame-Options", "DENY"},
     {"Referrer-Policy", "no-referrer"},
     {"Cross-Origin-Opener-Policy", "same-origin"},
     {"Cross-Origin-Resource-Policy", "same-origin"},
     {"Permissions-Policy", "camera=(), geolocation=(), microphone=()"},
     {"Cache-Control", "no-store"}}};

}  // namespace roadbalance
