// Players are used as <video> is.
const players = [...document.querySelectorAll("pointreel-player")];

document.querySelector("#together").onclick = () => {
  for (const player of players) {
    player.currentTime = 0;
    player.play();
  }
};

const show = () => {
  document.querySelector("#times").textContent =
    players.map((player) => `${player.currentTime.toFixed(1)} of ${player.duration.toFixed(1)} s`).join(", ");
};
for (const player of players) player.addEventListener("timeupdate", show);
