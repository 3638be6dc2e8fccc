#include "server/viewer_server.h"

#include "brim/core/error.h"
#include "server/http_server.h"
#include "server/viewer_routes.h"

namespace brim::viewer {

struct ViewerServer::Impl {
  ViewerRoutes routes;
  HttpServer http;

  Impl(RunSource& source, const std::filesystem::path& page)
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
             }) {}
};

ViewerServer::ViewerServer(RunSource& source, const std::filesystem::path& page)
    : impl_(std::make_unique<Impl>(source, page)) {}

ViewerServer::~ViewerServer() { stop(); }

int ViewerServer::bind(const std::string& host, int port) {
  impl_->routes.answer_any_host(!is_loopback(host));
  return impl_->http.bind(host, port);
}

void ViewerServer::listen() { impl_->http.listen(); }

void ViewerServer::stop() { impl_->http.stop(); }

}  // namespace brim::viewer
