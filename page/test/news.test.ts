import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { listenSlowly, News } from "../src/news";
import { Browser } from "./world";

let browser: Browser;
let news: News;
let drawings: number;
let end: () => void;

beforeEach(() => {
  vi.useFakeTimers();
  browser = new Browser();
  news = new News();
  drawings = 0;
  end = listenSlowly(news, 80, () => (drawings += 1));
});

afterEach(() => {
  end();
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

/** A time with a screen frame every 10 ms; news every `every` ms, if any. */
function pass(ms: number, every: number | null = null): void {
  for (let now = 0; now < ms; now += 10) {
    if (every !== null && now % every === 0) news.tell();
    browser.refresh();
    vi.advanceTimersByTime(10);
  }
}

test("news is drawn in the next screen frame", () => {
  news.tell();
  news.tell();
  expect(drawings).toBe(0);
  browser.refresh();
  expect(drawings).toBe(1);
});

test("without news nothing is drawn, and nothing waits", () => {
  pass(1000);
  expect(drawings).toBe(0);
  expect([vi.getTimerCount(), browser.requests]).toEqual([0, 0]);
});

test("news that comes seldom is drawn each time", () => {
  pass(1000, 100);
  expect(drawings).toBe(10);
});

test("news that comes often is drawn no more often than wanted, and the last of it is drawn", () => {
  pass(800, 20);
  expect(drawings).toBe(10);
  news.tell();
  pass(200);
  expect(drawings).toBe(11);
  expect([vi.getTimerCount(), browser.requests]).toEqual([0, 0]);
});

test("a hidden page draws no news, and catches up once when it is shown", () => {
  browser.hide(true);
  pass(1000, 100);
  expect(drawings).toBe(0);
  browser.hide(false);
  pass(1000);
  expect(drawings).toBe(1);
});

test("what has ended draws no more", () => {
  news.tell();
  browser.refresh();
  news.tell(); // waits
  end();
  pass(1000, 100);
  expect([drawings, vi.getTimerCount()]).toEqual([1, 0]);
});

test("all that is drawn in a screen frame shares one request, and one that fails keeps no other from it", () => {
  let others = 0;
  const fails = listenSlowly(news, 0, () => {
    throw new Error("it cannot be drawn");
  });
  const stop = listenSlowly(news, 0, () => (others += 1));
  news.tell();
  expect(browser.requests).toBe(1);
  expect(() => browser.refresh()).toThrow("cannot be drawn");
  news.tell();
  expect(() => browser.refresh()).toThrow("cannot be drawn");
  expect([drawings, others]).toEqual([1, 1]);
  fails();
  news.tell();
  browser.refresh();
  expect(others).toBe(2);
  stop();
});

test("what ends keeps nothing else from being drawn", () => {
  let others = 0;
  const stop = listenSlowly(news, 80, () => (others += 1));
  news.tell();
  end();
  browser.refresh();
  expect([drawings, others]).toEqual([0, 1]);
  stop();
});
