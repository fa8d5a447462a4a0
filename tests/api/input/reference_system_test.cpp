// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/reference_system.h"

#include <gtest/gtest.h>

#include <string>

namespace ccdt::api {
namespace {

/// Returns the name of a reference system, after `lonlat` or `other`.
std::string describe(std::string_view description) {
    const auto system = recognise_reference_system(description);
    return system ? (system->is_lonlat ? "lonlat " : "other ") + system->name : "none";
}

const std::string kWgs84 = R"(GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],)"
                           R"(PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]])";

TEST(ReferenceSystem, RecognisesWellKnownText) {
    EXPECT_EQ(describe(kWgs84), "lonlat GCS_WGS_1984");
    EXPECT_EQ(describe("\n " + kWgs84 + "\r\n"), "lonlat GCS_WGS_1984");
    EXPECT_EQ(describe("\xEF\xBB\xBF" + kWgs84), "lonlat GCS_WGS_1984");
    const std::string utm = R"(PROJCS["WGS_1984_UTM_Zone_32N",)" + kWgs84 +
                            R"(,PROJECTION["Transverse_Mercator"],PARAMETER["Scale_Factor",0.9996],UNIT["Meter",1.0]])";
    EXPECT_EQ(describe(utm), "other WGS_1984_UTM_Zone_32N");
    EXPECT_EQ(describe(R"(COMPD_CS["both",)" + utm + R"(,VERT_CS["height",UNIT["metre",1]]])"),
              "other WGS_1984_UTM_Zone_32N");
    EXPECT_EQ(describe(R"(COMPD_CS["both",)" + kWgs84 + R"(,VERT_CS["height",UNIT["metre",1]]])"),
              "lonlat GCS_WGS_1984");
    EXPECT_EQ(
        describe(R"(GEOGCRS["WGS 84",DATUM["World",ELLIPSOID["WGS 84",6378137,298.25,LENGTHUNIT["metre",1]]],)"
                 R"(CS[ellipsoidal,2],AXIS["lat",north],AXIS["lon",east],ANGLEUNIT["degree",0.0174532925199433]])"),
        "lonlat WGS 84");
    EXPECT_EQ(describe(R"(projcrs["RD New [Amersfoort]",BASEGEOGCRS["Amersfoort"]])"), "other RD New [Amersfoort]");
    EXPECT_EQ(describe(R"(LOCAL_CS["GEOGCS[",UNIT["metre",1]])"), "none");
}

TEST(ReferenceSystem, DistinguishesDegreesFromOtherUnits) {
    EXPECT_EQ(describe(R"x(GEOGCS["NTF (Paris)",PRIMEM["Paris",2.5969213],UNIT["Grad",0.01570796326794897]])x"),
              "other NTF (Paris)");
    EXPECT_EQ(describe(R"(GEOGCS["no unit"])"), "lonlat no unit");
}

TEST(ReferenceSystem, RecognisesNames) {
    EXPECT_EQ(describe("urn:ogc:def:crs:OGC:1.3:CRS84"), "lonlat urn:ogc:def:crs:OGC:1.3:CRS84");
    EXPECT_EQ(describe("EPSG:4326"), "lonlat EPSG:4326");
    EXPECT_EQ(describe("urn:ogc:def:crs:EPSG::3857"), "other urn:ogc:def:crs:EPSG::3857");
    EXPECT_EQ(describe("EPSG:2154"), "other EPSG:2154");
    EXPECT_EQ(describe("http://www.opengis.net/def/crs/EPSG/0/25832"),
              "other http://www.opengis.net/def/crs/EPSG/0/25832");
    for (const std::string_view unknown : {"", "[", "x", "\"", "EPSG:", "EPSG:4283", "GEOGCS", "((((", "]]]"})
        EXPECT_EQ(describe(unknown), "none") << unknown;
}

}  // namespace
}  // namespace ccdt::api
