// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>
#include <string>

#include <unistd.h>

namespace ccdt::server {

/// Returns the file of the certificate authorities for connections by TLS: that of SSL_CERT_FILE, that of the container
/// image, or Debian's. OpenSSL searches all of them, but libcurl only the last one.
inline std::string authorities_file() {
    const char* const chosen = std::getenv("SSL_CERT_FILE");
    const char* const of_image = "/usr/lib/ssl/cert.pem";
    if (chosen != nullptr) return chosen;
    return access(of_image, R_OK) == 0 ? of_image : "/etc/ssl/certs/ca-certificates.crt";
}

}  // namespace ccdt::server
