// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/monitoring/log.h"

#include <gtest/gtest.h>

namespace ccdt::server {
namespace {

Exchange example() {
    Exchange exchange;
    exchange.request.method = "POST";
    exchange.request.target = "/a=\"\r\n\x1b[1m\xff\\";
    exchange.response.status = 500;
    exchange.response.record.request_id = "abc-1";
    exchange.response.record.cause = "out of \"luck\"";
    exchange.response.record.stages = {1, {2, 3, 4, 5}};
    exchange.client = "127.0.0.1:5";
    exchange.bytes_in = 10;
    exchange.bytes_out = 20;
    exchange.milliseconds = 30;
    return exchange;
}

TEST(Log, WritesARequestOnOneLine) {
    EXPECT_EQ(exchange_line(example(), LogFormat::Text),
              R"(abc-1 127.0.0.1:5 POST /a=\"\u000d\u000a\u001b[1m\u00ff\\ 500 in=10 out=20 total=30.0 )"
              R"(queue=1.0 decode=2.0 prepare=3.0 optimise=4.0 encode=5.0 cause="out of \"luck\"")");
}

TEST(Log, WritesARequestAsJson) {
    EXPECT_EQ(exchange_line(example(), LogFormat::Json),
              R"("message":"request","id":"abc-1","client":"127.0.0.1:5","method":"POST",)"
              R"("target":"/a=\"\u000d\u000a\u001b[1m\u00ff\\","status":500,"bytes_in":10,"bytes_out":20,)"
              R"("total_ms":30.0,"queue_ms":1.0,"decode_ms":2.0,"prepare_ms":3.0,"optimise_ms":4.0,)"
              R"("encode_ms":5.0,"cause":"out of \"luck\"")");
}

TEST(Log, LogsKeyAndTrace) {
    Exchange exchange;
    exchange.response.record.key = "alice";
    exchange.request.headers = {{"Traceparent", "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"}};
    EXPECT_TRUE(exchange_line(exchange, LogFormat::Text)
                    .ends_with(" key=alice trace=0af7651916cd43dd8448eb211c80319c parent=b7ad6b7169203331"));
    EXPECT_TRUE(
        exchange_line(exchange, LogFormat::Json)
            .ends_with(R"(,"key":"alice","trace":"0af7651916cd43dd8448eb211c80319c","parent":"b7ad6b7169203331")"));
}

TEST(Log, LogsTheSignerOfAUrlButNotTheSignature) {
    Exchange exchange;
    exchange.response.record.signer = "site";
    exchange.request.target = "/halftone/cat.jpg?sites=5&expires=1800000000&signature=c2lnbmF0dXJl";
    const std::string line = exchange_line(exchange, LogFormat::Text);
    EXPECT_TRUE(line.ends_with(" signer=site")) << line;
    EXPECT_NE(line.find(" /halftone/cat.jpg?sites=5&***&*** "), std::string::npos) << line;
    EXPECT_TRUE(exchange_line(exchange, LogFormat::Json).ends_with(R"(,"signer":"site")"));
}

TEST(Log, LogsCacheHits) {
    Exchange exchange;
    exchange.response.record.cached = true;
    EXPECT_TRUE(exchange_line(exchange, LogFormat::Text).ends_with(" encode=0.0 cache=hit"));
    EXPECT_TRUE(exchange_line(exchange, LogFormat::Json).ends_with(R"(,"cache":"hit")"));
}

TEST(Log, ShortensLongTargets) {
    Exchange exchange = example();
    exchange.request.target = "/" + std::string(10'000, 'x');
    EXPECT_LT(exchange_line(exchange, LogFormat::Text).size(), 1'000u);
}

TEST(Log, RedactsEverythingInAQueryButOptions) {
    const auto shown = [](const std::string& target) {
        Exchange exchange;
        exchange.request.method = "GET";
        exchange.request.target = target;
        const std::string line = exchange_line(exchange, LogFormat::Text);
        const std::size_t begin = std::string_view("- - GET ").size();
        return line.substr(begin, line.find(' ', begin) - begin);
    };
    const std::string options = "/halftone?sites=5&palette=%23c30,%23036&scale=1.5&format=json&&antialias";
    EXPECT_EQ(shown(options), options);
    for (const char* name : {"key", "api_key", "token", "access_token", "Key", "sites%20", "site", "auth", "%6bey"})
        EXPECT_EQ(shown("/halftone?" + std::string(name) + "=0123456789abcdef&seed=1"), "/halftone?***&seed=1") << name;
    EXPECT_EQ(shown("/metrics?0123456789abcdef"), "/metrics?***");
    EXPECT_EQ(shown("/halftone?sites=5?key=0123456789abcdef"), "/halftone?***");
    EXPECT_EQ(shown("/halftone?sites=5;key=0123456789abcdef"), "/halftone?***");
    EXPECT_EQ(shown("/halftone?sites=5%26key%3D0123456789abcdef"), "/halftone?***");
    EXPECT_EQ(shown("http://h/halftone?key=0123456789abcdef"), "http://h/halftone?***");
    EXPECT_EQ(shown("/halftone?seed=1#0123456789abcdef"), "/halftone?seed=1#***");
    EXPECT_EQ(shown("/halftone#?key=0123456789abcdef"), "/halftone#***");
    EXPECT_EQ(shown("/halftone?"), "/halftone");
}

TEST(Log, WritesAJobOnOneLine) {
    JobEnd end;
    end.job.id = "0123";
    end.job.owner = "alice";
    end.job.status = JobStatus::Failed;
    end.job.failure = Problem{500, {}};
    end.stages = {1, {2, 3, 4, 5}};
    end.cause = "out of \"luck\"";
    EXPECT_EQ(
        job_line(end, LogFormat::Text),
        R"(job 0123 failed result=0 queue=1.0 decode=2.0 prepare=3.0 optimise=4.0 encode=5.0 error=500 key=alice )"
        R"(cause="out of \"luck\"")");
    EXPECT_EQ(
        job_line(end, LogFormat::Json),
        R"("message":"job","job":"0123","status":"failed","result_bytes":0,"queue_ms":1.0,"decode_ms":2.0,)"
        R"("prepare_ms":3.0,"optimise_ms":4.0,"encode_ms":5.0,"error":500,"key":"alice","cause":"out of \"luck\"")");
}

TEST(Log, LogsTheTraceOfAJob) {
    JobEnd end;
    end.job.traceparent = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";
    EXPECT_NE(job_line(end, LogFormat::Text).find(" trace=0af7651916cd43dd8448eb211c80319c parent=b7ad6b7169203331"),
              std::string::npos);
    EXPECT_NE(job_line(end, LogFormat::Json)
                  .find(R"(,"trace":"0af7651916cd43dd8448eb211c80319c","parent":"b7ad6b7169203331")"),
              std::string::npos);
}

TEST(Log, LogsDashesForMissingFields) {
    EXPECT_TRUE(exchange_line({}, LogFormat::Text).starts_with("- - - - 200 "));
}

}  // namespace
}  // namespace ccdt::server
