# Varnish in front of  pointreel-server serve REEL... --live , or of nginx as in live.conf: of many
# requests for the same file at the same time, one goes on, and its answer is for all. Adapt the lines
# marked with "change", and start
#   varnishd -a :80 -f live.vcl -s malloc,1g
# What live.conf says about addresses and tokens holds for Varnish, too.
vcl 4.1;

backend pointreel {
  .host = "127.0.0.1";  # change: where pointreel-server or nginx listens
  .port = "8090";
}

sub vcl_recv {
  # On loopback, pointreel-server answers only for this host. Pages in browsers need --allow-origin.
  set req.http.Host = "localhost";
  if (req.url ~ "^/metrics") { return (synth(403)); }  # not for the public
  # Live streams over WebSocket.
  if (req.http.Upgrade ~ "(?i)websocket") { return (pipe); }
}

sub vcl_pipe {
  if (req.http.Upgrade) {
    set bereq.http.Upgrade = req.http.Upgrade;
    set bereq.http.Connection = req.http.Connection;
  }
}

sub vcl_backend_response {
  # The copy of a live stream's manifest that has just expired is for those who ask while a new one is
  # fetched, and not for anybody later.
  set beresp.grace = 1s;
  set beresp.keep = 1m;  # validated by entity tags
}
