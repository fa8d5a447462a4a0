#include "server/processes/signals.h"

#include <csignal>
#include <initializer_list>

namespace ccdt::server {

void leave_signals_to_server() {
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) std::signal(number, SIG_IGN);
}

}  // namespace ccdt::server
