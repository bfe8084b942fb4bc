/** Exports of a behavior: what they are called, and how one is asked for. */

/** Explanations of targets whose names say little; other targets are shown by name. */
const TARGETS: Readonly<Record<string, string>> = {
  c99: "C code",
  python: "Python module",
  json: "JSON documents",
  ros2: "ROS 2 package",
  btcpp: "BehaviorTree.CPP",
  scxml: "SCXML statechart",
  xstate: "XState machine",
};
/** The targets for which a robot's file says what is read and commanded. */
const ROBOTS: readonly string[] = ["ros2"];

export interface ExportRequest {
  name: string;
  to: string;
  targets: Readonly<Record<string, string>>;
  single: boolean;
}

export function targetName(target: string): string {
  return TARGETS[target] ?? target;
}

export function needsRobot(target: string): boolean {
  return ROBOTS.includes(target);
}

/** The query of an export. */
export function exportQuery(request: ExportRequest): [string, string][] {
  const { name, to, targets, single } = request;
  return [
    ["name", name],
    ["to", to],
    ...Object.entries(targets).map(([parameter, target]): [string, string] => [
      "bind",
      `${parameter}=${target}`,
    ]),
    ...(single ? ([["single", "1"]] as [string, string][]) : []),
  ];
}

/** The name in a Content-Disposition, or another where there is none. */
export function fileName(disposition: string | null, otherwise: string): string {
  return /filename="([^"/\\]+)"/.exec(disposition ?? "")?.[1] ?? otherwise;
}

/** Offer a file as a download. */
export function saveFile(content: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000); // some browsers read it later
}
