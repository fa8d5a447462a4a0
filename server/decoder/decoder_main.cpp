// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstdio>

#include <fcntl.h>

#include "api/decode/decode.h"
#include "api/image/decoder_warm_up.h"
#include "api/image/image_codec.h"
#include "api/map/code_page.h"
#include "api/map/shapefile_reader.h"
#include "server/decoder/decoder_helper.h"
#include "server/processes/child_program.h"

/// The main function of ccdt-decoder, which the server starts: the decoder's helper.
int main() {
    using namespace ccdt;
    server::UniqueFd orders(server::ChildProgram::kSocket);
    if (fcntl(orders.get(), F_GETFD) < 0) {
        std::fputs("ccdt-decoder: ccdt-server starts this program\n", stderr);
        return 2;
    }
    const auto warm_up = [] {
        api::warm_up_decoder();
        api::load_code_pages();
    };
    server::run_decoder_helper(std::move(orders), {api::decode_image, api::decode_colour_image, warm_up,
                                                   api::read_shapefile, api::read_surface_with_pictures});
}
