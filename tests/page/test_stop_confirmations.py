"""New stops from a page, and the requests that a page made before one."""

from __future__ import annotations

from improv_core.page.stop_confirmations import MAX_PAGES, Order, PageStops

PAGE, OTHER = "a page", "another page"


def test_a_repeated_or_duplicate_stop_is_obeyed_once() -> None:
    stops = PageStops()
    order = Order(stops, PAGE)
    assert [stops.arrive(PAGE, 1), stops.arrive(PAGE, 1), order.stop(1)] == [True, False, False]
    assert [order.stop(2), stops.arrive(PAGE, 2), stops.arrive(PAGE, 1)] == [True, False, False]
    assert stops.arrive(OTHER, 1)


def test_requests_sent_before_a_stop_that_arrive_after_it_are_recognized() -> None:
    stops = PageStops()
    order, other = Order(stops, PAGE), Order(stops, OTHER)
    assert not order.lags
    stops.arrive(PAGE, 1)  # it overtook the page's earlier requests
    assert order.lags
    assert not other.lags
    order.stop(1)
    assert not order.lags  # sent after the stop
    stops.arrive(PAGE, 2)
    stops.arrive(PAGE, 3)
    order.stop(2)
    assert order.lags


def test_nothing_older_than_a_stop_comes_over_a_new_connection() -> None:
    stops = PageStops()
    stops.arrive(PAGE, 4)
    assert not Order(stops, PAGE).lags


def test_a_stop_is_confirmed_with_all_that_came_before_it() -> None:
    stops = PageStops()
    assert not stops.is_confirmed(PAGE, 1)
    stops.obeyed(f"{PAGE} 2")
    assert [stops.is_confirmed(PAGE, number) for number in (1, 2, 3)] == [True, True, False]
    stops.obeyed(f"{PAGE} 1")
    assert stops.is_confirmed(PAGE, 2)


def test_those_yet_to_obey_a_stop_are_known_until_the_next_one() -> None:
    stops = PageStops()
    stops.arrive(PAGE, 1)
    stops.obeyed(f"{PAGE} 1", ["ada", "bo"])
    stops.arrive(PAGE, 1)  # sent again
    assert [stops.waits_for(PAGE), stops.waits_for(OTHER)] == ["ada, bo", ""]
    stops.arrive(PAGE, 2)
    stops.obeyed(f"{PAGE} 1", ["ada"])
    assert stops.waits_for(PAGE) == ""


def test_pages_that_were_closed_are_forgotten() -> None:
    stops = PageStops()
    for number in range(MAX_PAGES + 1):
        stops.arrive(f"page {number}", 1)
    assert stops.arrive("page 0", 1)
    assert not stops.arrive(f"page {MAX_PAGES}", 1)
