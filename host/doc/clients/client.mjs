// Node, without a package.
import { connect } from "node:net";
import { createInterface } from "node:readline";

const [host, port] = (process.argv[2] ?? "127.0.0.1:7002").split(":");
const socket = connect(Number(port), host);
const lines = createInterface({ input: socket })[Symbol.asyncIterator]();
async function ask(request, fields = {}) {
  socket.write(JSON.stringify({ do: request, ...fields }) + "\n");
  const answer = JSON.parse((await lines.next()).value);
  if (!answer.ok) throw new Error(answer.text);
  return answer;
}
await ask("arm");
await ask("regulate", { angle_rad: [0, 0] });
await ask("move", { angle_rad: [0.2, -0.1], duration_s: 1 });
await ask("take");
const { columns } = await ask("take", { ticks: 500, columns: ["angle_rad"] });
const mean = (values) => values.reduce((sum, value) => sum + value) / values.length;
await ask("park");
console.log(`angles ${mean(columns.angle_rad_1).toFixed(3)} and ${mean(columns.angle_rad_2).toFixed(3)} rad`);
socket.end();
