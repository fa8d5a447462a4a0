// SPDX-License-Identifier: GPL-3.0-or-later
// Uses libccdt-api: files OPERATION INPUT OUTPUT [NAME VALUE]...
#include <ccdt/service.h>

#include <cstdio>
#include <cstring>
#include <vector>

int main(int count, char** arguments) {
    std::vector<ccdt::Option> options;
    for (int i = 4; i + 1 < count; i += 2) options.push_back({arguments[i], arguments[i + 1]});
    const auto operation = std::strcmp(arguments[1], "halftone") == 0 ? ccdt::Operation::Halftone
                           : std::strcmp(arguments[1], "sample") == 0 ? ccdt::Operation::Sample
                                                                      : ccdt::Operation::Analyze;
    try {
        const auto answer = ccdt::answer_file(operation, arguments[2], arguments[3], options);
        std::printf("%s\n", answer.media_type.c_str());
    } catch (const ccdt::Exception& exception) {
        std::printf("%d %s: %s\n", static_cast<int>(exception.code()), exception.field().c_str(), exception.what());
        return 1;
    }
}
