#include "server/viewer_server.h"

#include "brim/core/error.h"
#include "server/http_server.h"
#include "server/viewer_routes.h"

namespace brim::viewer {

namespace {

constexpr std::chrono::milliseconds kInteractive{30};  // between looks for frames where a person pulls at them

}  // namespace

struct ViewerServer::Impl {
  ViewerRoutes routes;
  HttpServer http;

  Impl(RunSource& source, const std::filesystem::path& page, ViewerRoutes::Tell tell)
      : routes(source, page),
        http([this](const HttpRequest& request) { return routes.answer(request); },
             [&source, told = Progress()]() mutable {
               try {
                 told = source.progress();
               } catch (const std::exception&) {
                 // The file is gone for the moment; pages go on with what they have.
               }
               return fmt::format("event: frames\ndata: {{\"frames\":{},\"complete\":{},\"stopped\":{}}}\n\n",
                                  told.frames, told.complete, told.stopped);
             }) {
    if (tell) http.look_every(kInteractive);
    routes.pass_on(std::move(tell));
  }
};

ViewerServer::ViewerServer(RunSource& source, const std::filesystem::path& page,
                           std::function<bool(const std::string&)> tell)
    : impl_(std::make_unique<Impl>(source, page, std::move(tell))) {}

ViewerServer::~ViewerServer() { stop(); }

int ViewerServer::bind(const std::string& host, int port) {
  impl_->routes.answer_any_host(!is_loopback(host));
  return impl_->http.bind(host, port);
}

void ViewerServer::listen() { impl_->http.listen(); }

void ViewerServer::stop() { impl_->http.stop(); }

}  // namespace brim::viewer
