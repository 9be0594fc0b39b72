// Packages on their way into an object store, and what stores do wrong.

#include "server/store/upload.h"

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/source/open_source.h"
#include "codec/package/manifest.h"
#include "server/store/package_files.h"
#include "tests/served_package.h"
#include "tests/small_package.h"
#include "tests/system/fake_store.h"

namespace pointreel::upload_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using Requests = std::vector<std::string>;

class Upload : public testing::Test {
 protected:
  void SetUp() override {
    ::setenv("AWS_ACCESS_KEY_ID", "AKID", 1);
    ::setenv("AWS_SECRET_ACCESS_KEY", "hush-hush", 1);
    ::setenv("AWS_SESSION_TOKEN", "hush-token", 1);
    write_package(reel(), patterned(1000), patterned(3 << 20));
  }
  void TearDown() override {
    for (const char* name : {"AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY", "AWS_SESSION_TOKEN"})
      ::unsetenv(name);
  }
  std::filesystem::path reel() const { return folder_ / "walk"; }

  static HttpOptions http(const std::string& endpoint) {
    HttpOptions options = patient();
    options.endpoint = endpoint;
    options.fetch_attempts = 3;
    return options;
  }
  UploadOptions options(const std::string& endpoint) const {
    UploadOptions options;
    options.to = "s3://reels/a walk";
    options.http = http(endpoint);
    return options;
  }
  Result<UploadSummary> upload(const UploadOptions& options) const {
    auto uploader = Uploader::open(options);
    if (!uploader) return tl::unexpected(uploader.error());
    return uploader->upload(reel());
  }
  /// The error of uploading to a store that answers like this.
  std::string error(FakeStore::Instead instead) const {
    const FakeStore store(std::move(instead));
    const auto summary = upload(options(store.url()));
    const std::string line = summary ? "none" : summary.error().message;
    EXPECT_THAT(line, AllOf(Not(HasSubstr("hush")), Not(HasSubstr("\n"))));
    return line;
  }
  /// Answers everything that is sent with this.
  static FakeStore::Instead to_puts(std::string status, std::string body,
                                    std::string headers = "") {
    return [=](int socket, const std::string& head) {
      if (!head.starts_with("PUT")) return false;
      answer(socket, status, headers, body);
      return true;
    };
  }

  TemporaryFolder folder_;
};

TEST_F(Upload, sends_files_first_and_the_manifest_last) {
  const FakeStore store;
  const auto summary = upload(options(store.url()));
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_EQ(summary->files, 3u);
  EXPECT_EQ(summary->kept, 0u);
  const auto objects = store.objects();
  ASSERT_EQ(objects.size(), 3u);
  EXPECT_EQ(objects.at("/reels/a%20walk/0.base.prs").body, patterned(1000));
  EXPECT_EQ(objects.at("/reels/a%20walk/0.full.prs").body, patterned(3 << 20));
  EXPECT_TRUE(parse_manifest(objects.at("/reels/a%20walk/reel.json").body));
  EXPECT_EQ(store.requests().back(), "PUT /reels/a%20walk/reel.json");
}

TEST_F(Upload, tells_caches_what_they_may_keep) {
  const FakeStore store;
  ASSERT_TRUE(upload(options(store.url())));
  const auto objects = store.objects();
  EXPECT_THAT(objects.at("/reels/a%20walk/0.base.prs").head,
              AllOf(HasSubstr("Cache-Control: public, max-age=31536000, immutable\r\n"),
                    HasSubstr("Content-Type: application/octet-stream\r\n"),
                    HasSubstr("Content-MD5: "), HasSubstr("x-amz-security-token: hush-token\r\n"),
                    HasSubstr("Authorization: AWS4-HMAC-SHA256 Credential=AKID/")));
  EXPECT_THAT(objects.at("/reels/a%20walk/reel.json").head,
              AllOf(HasSubstr("Cache-Control: no-cache\r\n"),
                    HasSubstr("Content-Type: application/json\r\n")));
}

TEST_F(Upload, goes_on_where_it_was_interrupted) {
  FakeStore store;
  ASSERT_TRUE(upload(options(store.url())));
  const auto again = upload(options(store.url()));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->files, 0u);
  EXPECT_EQ(again->kept, 3u);

  store.remove("/reels/a%20walk/reel.json");
  store.remove("/reels/a%20walk/0.full.prs");
  const auto rest = upload(options(store.url()));
  ASSERT_TRUE(rest) << rest.error().message;
  EXPECT_EQ(rest->files, 2u);
  EXPECT_EQ(rest->kept, 1u);
  EXPECT_EQ(store.objects().size(), 3u);
}

TEST_F(Upload, mends_what_lies_under_the_same_manifest_if_forced) {
  FakeStore store;
  ASSERT_TRUE(upload(options(store.url())));
  store.remove("/reels/a%20walk/0.full.prs");
  UploadOptions force = options(store.url());
  force.force = true;
  const auto mended = upload(force);
  ASSERT_TRUE(mended) << mended.error().message;
  EXPECT_EQ(mended->files, 2u) << "and the manifest";
  EXPECT_EQ(mended->kept, 1u);
  EXPECT_EQ(store.objects().size(), 3u);
}

TEST_F(Upload, names_what_is_there_and_is_no_reel) {
  const FakeStore store([](int socket, const std::string& head) {
    if (!head.starts_with("GET ")) return false;
    answer(socket, "200 OK", "", "<html>Welcome</html>");
    return true;
  });
  const auto refused = upload(options(store.url()));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message,
              AllOf(HasSubstr("s3://reels/a walk: what is there already is not a reel"),
                    HasSubstr("check --endpoint")));
}

TEST_F(Upload, replaces_another_reel_only_if_asked) {
  const FakeStore store;
  ASSERT_TRUE(upload(options(store.url())));
  std::filesystem::remove_all(reel());
  write_package(reel(), patterned(500), patterned(2000));
  const auto refused = upload(options(store.url()));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message,
            "s3://reels/a walk: another reel is there already; --force replaces it");
  UploadOptions force = options(store.url());
  force.force = true;
  const auto replaced = upload(force);
  ASSERT_TRUE(replaced) << replaced.error().message;
  EXPECT_EQ(store.objects().at("/reels/a%20walk/0.base.prs").body, patterned(500));
}

TEST_F(Upload, sends_no_file_that_is_damaged) {
  write_file(reel() / "0.base.prs", patterned(999) + "x");
  const FakeStore store;
  const auto summary = upload(options(store.url()));
  ASSERT_FALSE(summary);
  EXPECT_THAT(summary.error().message, AllOf(HasSubstr("0.base.prs: has other bytes"),
                                             HasSubstr("pointreel-server verify")));
  EXPECT_FALSE(store.objects().contains("/reels/a%20walk/reel.json"));
}

TEST_F(Upload, waits_for_a_store_that_is_busy) {
  int busy = 2;
  const FakeStore store([&](int socket, const std::string& head) {
    if (!head.starts_with("PUT") || busy == 0) return false;
    --busy;
    answer(socket, "503 Slow Down", "", "<Error><Code>SlowDown</Code></Error>");
    return true;
  });
  UploadOptions patient = options(store.url());
  patient.http.open_attempts = 5;
  const auto summary = upload(patient);
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_EQ(store.objects().size(), 3u);
}

TEST_F(Upload, refusals_are_explained_in_one_line) {
  EXPECT_THAT(error(to_puts("403 Forbidden", "<Error><Code>AccessDenied</Code></Error>")),
              AllOf(HasSubstr("/reels/a%20walk/0."), HasSubstr("answers 403 (AccessDenied)"),
                    HasSubstr("check the keys")));
  EXPECT_THAT(error(to_puts("403 Forbidden", "<Error><Code>RequestTimeTooSkewed</Code></Error>")),
              HasSubstr("set the clock"));
  EXPECT_THAT(error(to_puts("404 Not Found", "<Error><Code>NoSuchBucket</Code></Error>")),
              HasSubstr("create the bucket"));
  EXPECT_THAT(error(to_puts("503 Slow Down", "<Error><Code>SlowDown</Code></Error>")),
              AllOf(HasSubstr("(SlowDown)"), HasSubstr("try again later (3 attempts)")));
  EXPECT_THAT(error(to_puts("500 Oops", "<Error><Code>\x1b[2J<<<")),
              HasSubstr("the server answers 500 (3 attempts)"));
  EXPECT_THAT(error(to_puts("400 Bad", std::string(1 << 20, '<'))), HasSubstr("answers 400"));
}

TEST_F(Upload, wrong_keys_are_found_before_anything_is_sent) {
  const FakeStore store([](int socket, const std::string&) {
    answer(socket, "403 Forbidden", "", "<Error><Code>SignatureDoesNotMatch</Code></Error>");
    return true;
  });
  const auto uploader = Uploader::open(options(store.url()));
  ASSERT_FALSE(uploader);
  EXPECT_THAT(uploader.error().message,
              AllOf(HasSubstr("(SignatureDoesNotMatch); check AWS_SECRET_ACCESS_KEY"),
                    Not(HasSubstr("hush"))));
  EXPECT_EQ(store.requests(), Requests{"GET /reels/a%20walk/reel.json"});
}

TEST_F(Upload, keys_go_to_no_other_address) {
  const FakeStore other;
  const std::string line = error([&](int socket, const std::string&) {
    answer(socket, "307 Temporary Redirect", "Location: " + other.url() + "/x\r\n",
           "<Error><Code>TemporaryRedirect</Code></Error>");
    return true;
  });
  EXPECT_THAT(line,
              AllOf(HasSubstr("the bucket is at another address"), HasSubstr("set AWS_REGION")));
  EXPECT_EQ(other.requests(), Requests{});
}

TEST_F(Upload, what_has_not_arrived_as_it_was_sent_is_sent_again) {
  const FakeStore before;
  ASSERT_TRUE(upload(options(before.url())));
  const auto objects = before.objects();
  // The checksum is what the uploader has said, and the tag is of what the store has.
  const FakeStore store([&](int socket, const std::string& head) {
    if (!head.starts_with("HEAD ")) return false;
    const auto& object = objects.at(head.substr(5, head.find(' ', 5) - 5));
    const std::string name = "x-amz-meta-xxh3: ";
    send_text(socket, fmt::format("HTTP/1.1 200 OK\r\nContent-Length: {}\r\n{}{}\r\nETag: "
                                  "\"0123456789abcdef0123456789abcdef\"\r\n\r\n",
                                  object.body.size(), name,
                                  object.head.substr(object.head.find(name) + name.size(), 16)));
    return true;
  });
  const auto again = upload(options(store.url()));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->files, 3u);
  EXPECT_EQ(again->kept, 0u);
}

TEST_F(Upload, a_store_that_keeps_other_bytes_is_noticed) {
  EXPECT_THAT(error(to_puts("200 OK", "", "ETag: \"0123456789abcdef0123456789abcdef\"\r\n")),
              HasSubstr("has stored other bytes than were sent"));
  // Tags of what is encrypted say nothing about the bytes.
  const FakeStore encrypting(to_puts("200 OK", "",
                                     "ETag: \"0123456789abcdef0123456789abcdef\"\r\n"
                                     "x-amz-server-side-encryption: aws:kms\r\n"));
  EXPECT_TRUE(upload(options(encrypting.url())));
}

TEST_F(Upload, what_is_no_place_in_a_store_is_refused) {
  for (const char* to : {"https://host/reel", "reel", "s3://bucket"}) {
    UploadOptions options;
    options.to = to;
    const auto uploader = Uploader::open(options);
    ASSERT_FALSE(uploader) << to;
    EXPECT_THAT(uploader.error().message, HasSubstr("give s3://BUCKET/REEL"));
  }
}

TEST_F(Upload, players_and_programs_read_what_was_uploaded) {
  const FakeStore store([](int socket, const std::string& head) {
    if (!head.starts_with("GET") || head.find("0.base.prs") == std::string::npos) return false;
    const RequestedRange range = range_of(head);
    answer(socket, "206 Partial Content",
           fmt::format("Content-Range: bytes {}-{}/1000\r\n", range.first, range.last),
           patterned(1000).substr(range.first, range.last - range.first + 1));
    return true;
  });
  ASSERT_TRUE(upload(options(store.url())));
  SourceOptions source_options = patient();
  source_options.endpoint = store.url();
  const auto source = open_source("s3://reels/a walk", source_options);
  ASSERT_TRUE(source) << source.error().message;
  const auto frame = (*source)->fetch({0, {0, 1, true, true}});
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->layers[0].bytes.size(), 1000u);

  std::filesystem::path fetched;
  {
    const auto files = PackageFiles::at("s3://reels/a walk", http(store.url()));
    ASSERT_TRUE(files) << files.error().message;
    const auto manifest = files->manifest();
    ASSERT_TRUE(manifest) << manifest.error().message;
    const auto local = files->local(manifest->segments[0].layers[0]);
    ASSERT_TRUE(local) << local.error().message;
    fetched = *local;
    EXPECT_EQ(std::filesystem::file_size(fetched), 1000u);
  }
  EXPECT_FALSE(std::filesystem::exists(fetched.parent_path()));
}

TEST_F(Upload, a_file_of_another_length_or_none_is_an_error_of_its_address) {
  const auto error_of = [&](FakeStore::Instead instead) {
    const FakeStore store(std::move(instead));
    EXPECT_TRUE(upload(options(store.url())));
    const auto files = PackageFiles::at("s3://reels/a walk", http(store.url()));
    const auto local = files->local(files->manifest()->segments[0].layers[0]);
    return local ? "none" : local.error().message;
  };
  const auto to_layer = [](std::string status, std::string headers, std::string body) {
    return [=](int socket, const std::string& head) {
      if (!head.starts_with("GET") || head.find("0.base.prs") == std::string::npos) return false;
      answer(socket, status, headers, body);
      return true;
    };
  };
  EXPECT_THAT(error_of(to_layer("206 Partial Content", "Content-Range: bytes 0-999/2000\r\n",
                                patterned(1000))),
              AllOf(HasSubstr("/reels/a%20walk/0.base.prs: asked for bytes"),
                    HasSubstr("the package has changed")));
  EXPECT_THAT(error_of(to_layer("200 OK", "", patterned(999))),
              HasSubstr("999 bytes came instead of 1000"));
  EXPECT_THAT(error_of(to_layer("404 Not Found", "", "<Error><Code>NoSuchKey</Code></Error>")),
              HasSubstr("answers 404 (NoSuchKey)"));
  EXPECT_THAT(error_of([](int socket, const std::string& head) {
                if (!head.starts_with("GET") || head.find("0.base") == std::string::npos)
                  return false;
                send_text(socket,
                          "HTTP/1.1 206 Partial Content\r\nContent-Length: 1000\r\n"
                          "Content-Range: bytes 0-999/1000\r\n\r\nabc");
                ::shutdown(socket, SHUT_RDWR);
                return true;
              }),
              HasSubstr("(3 attempts)"));
}

}  // namespace
}  // namespace pointreel::upload_test
