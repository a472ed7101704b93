% Made from table.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(table, []).
:- use_module(facetlog(vocabulary)).
% table.model:4
model(table, "A level top with free space beneath it, on legs or panels that reach the ground.",
      [top]).

% table.model:11  parts
candidate(table, Thing, Parts) :-
    findall(Parts, likely(table, Thing, Parts), Found),
    ( Found == [] -> distant(table, Thing, Parts) ; member(Parts, Found) ).

% table.model:11  all that may satisfy its lines
likely(table, Thing, [Top]) :-
    face_of(Thing, Top),
    possible(all([measured(Top), level(Top), upward(Top),
                  any([at_least(share(Top), 0.8),
                       all([whole(Thing), at_least(cover(Top), 0.75)])]),
                  any([at_most(protrusion(Top), 0.1*elevation(Top)),
                       all([whole(Thing), at_most(protrusion(Top), 0.4*elevation(Top))])]),
                  any([all([whole(Thing), at_least(level_width(Top), 0.35*elevation(Top)),
                            at_least(elevation(Top), 0.12*level_length(Top))]),
                       all([not(whole(Thing)), at_least(width(Top), 0.25*elevation(Top)),
                            at_least(elevation(Top), 0.15*length(Top))])])])).

% table.model:11  near misses
distant(table, Thing, [Top]) :-
    as_far_as_seen(Thing, [step(Top, 20, all([measured(Top), level(Top), upward(Top)]))], [Top]).

% table.model:12  closed closes top
means('table.closed'(Closed, Top), closes(Closed, Top)).
% table.model:13  leg supports top
means('table.leg'(Leg, Top), supports(Leg, Top)).
% table.model:14  panel supports top, wide(panel)
means('table.panel'(Panel, Top),
      all([supports(Panel, Top), soft(at_least(width(Panel), 0.5*width(Top)), 0.1)])).

% table.model:12
members(table, closed, _, [Top], Members) :-
    findall(Closed, ( shared_edge(Top, Closed, _), possible('table.closed'(Closed, Top)) ),
            Found),
    sort(Found, Members).
% table.model:13
members(table, leg, Thing, [Top], Members) :-
    findall(Leg,
            ( element_of(Thing, Leg), \+ memberchk(Leg, [Top]), possible('table.leg'(Leg, Top)) ),
            Found),
    sort(Found, Members).
% table.model:14
members(table, panel, Thing, [Top], Members) :-
    findall(Panel,
            ( face_of(Thing, Panel), \+ memberchk(Panel, [Top]),
              possible('table.panel'(Panel, Top)) ), Found),
    sort(Found, Members).

% table.model:18  top is measured, top is level, top is upward
condition(table, level, "the top is level and faces up", _, [Top],
          all([measured(Top), level(Top), upward(Top)])).
% table.model:19  share(top) at least 80 % or this is whole and cover(top) at least 75 %
condition(table, cover, "the top covers the thing seen from above", Thing, [Top],
          any([soft(at_least(share(Top), 0.8), 0.1),
               all([whole(Thing), soft(at_least(cover(Top), 0.75), 0.1)])])).
% table.model:22  protrusion(top) at most 10 % of elevation(top) or this is whole and protrusion(top) at most 40 % of elevation(top)
condition(table, topmost, "nothing rises above the top but what may stand on it", Thing, [Top],
          any([soft(at_most(protrusion(Top), 0.1*elevation(Top)), 0.1),
               all([whole(Thing), soft(at_most(protrusion(Top), 0.4*elevation(Top)), 0.1)])])).
% table.model:26  this is whole and free_below(top) at least 60 % or this is not whole and (free(top) or there is a face f where f underside_of top, free(f))
condition(table, room, "there is free space beneath the top", Thing, [Top],
          any([all([whole(Thing), soft(at_least(free_below(Top), 0.6), 0.1)]),
               all([not(whole(Thing)),
                    any([soft(at_least(clear_below(Top), 0.5*elevation(Top)), 0.1),
                         some(F, Fs,
                              all([underside_of(F, Top),
                                   soft(at_least(clear_below(F), 0.5*elevation(Top)), 0.1)]))])])])) :-
    findall(F,
            ( face_of(Thing, F), \+ memberchk(F, [Top]),
              possible(all([underside_of(F, Top), at_least(clear_below(F), 0.5*elevation(Top))])) ),
            Found),
    sort(Found, Fs).
% table.model:30  this is whole and open_from_two_sides(top) at least 30 % or this is not whole and (each pair x, y of closed: not x adjoins y)
condition(table, open, "no two neighbouring sides are closed", Thing, [Top],
          any([all([whole(Thing), soft(at_least(open_from_two_sides(Top), 0.3), 0.1)]),
               all([not(whole(Thing)),
                    each_pair(X, Y, Closed_members,
                              implies(all(['table.closed'(X, Top), 'table.closed'(Y, Top)]),
                                      not(adjoins(X, Y))))])])) :-
    members(table, closed, Thing, [Top], Closed_members).
% table.model:33  count(leg) at least 3 or count(panel) at least 2 or this is whole
condition(table, support, "it stands on three legs or two panels at least", Thing, [Top],
          any([at_least_of(3, Leg, Leg_groups, 'table.leg'(Leg, Top)),
               at_least_of(2, Panel, Panel_groups, 'table.panel'(Panel, Top)), whole(Thing)])) :-
    members(table, leg, Thing, [Top], Leg_members),
    separate(Leg_members, Leg_groups),
    members(table, panel, Thing, [Top], Panel_members),
    separate(Panel_members, Panel_groups).
% table.model:36  this is whole and level_width(top) at least 35 % of elevation(top) and elevation(top) at least 12 % of level_length(top) or this is not whole and width(top) at least 25 % of elevation(top) and elevation(top) at least 15 % of length(top)
condition(table, proportion, "the top is no pole and no tray", Thing, [Top],
          any([all([whole(Thing), soft(at_least(level_width(Top), 0.35*elevation(Top)), 0.1),
                    soft(at_least(elevation(Top), 0.12*level_length(Top)), 0.1)]),
               all([not(whole(Thing)), soft(at_least(width(Top), 0.25*elevation(Top)), 0.1),
                    soft(at_least(elevation(Top), 0.15*length(Top)), 0.1)])])).
% table.model:40  elevation(top) between 30 cm and 120 cm
condition(table, usual, "tables are 30 cm to 120 cm high", _, [Top],
          expect(0.25, if_known(soft(between(elevation(Top), metres(0.3), metres(1.2)), 0.1)))).

written(table, level, 'table.model:18', "top is measured, top is level, top is upward").
written(table, cover, 'table.model:19',
        "share(top) at least 80 % or this is whole and cover(top) at least 75 %").
written(table, topmost, 'table.model:22',
        "protrusion(top) at most 10 % of elevation(top) or this is whole and protrusion(top) at most 40 % of elevation(top)").
written(table, room, 'table.model:26',
        "this is whole and free_below(top) at least 60 % or this is not whole and (free(top) or there is a face f where f underside_of top, free(f))").
written(table, open, 'table.model:30',
        "this is whole and open_from_two_sides(top) at least 30 % or this is not whole and (each pair x, y of closed: not x adjoins y)").
written(table, support, 'table.model:33',
        "count(leg) at least 3 or count(panel) at least 2 or this is whole").
written(table, proportion, 'table.model:36',
        "this is whole and level_width(top) at least 35 % of elevation(top) and elevation(top) at least 12 % of level_length(top) or this is not whole and width(top) at least 25 % of elevation(top) and elevation(top) at least 15 % of length(top)").
written(table, usual, 'table.model:40', "elevation(top) between 30 cm and 120 cm").

% table.model:12
group(table, Thing, [Top], closed, Members) :-
    members(table, closed, Thing, [Top], Closed_members),
    findall(Closed, ( member(Closed, Closed_members), holds('table.closed'(Closed, Top)) ),
            Members).
% table.model:13
group(table, Thing, [Top], leg, Members) :-
    members(table, leg, Thing, [Top], Leg_members),
    findall(Leg, ( member(Leg, Leg_members), holds('table.leg'(Leg, Top)) ), Members).
% table.model:14
group(table, Thing, [Top], panel, Members) :-
    members(table, panel, Thing, [Top], Panel_members),
    findall(Panel, ( member(Panel, Panel_members), holds('table.panel'(Panel, Top)) ), Members).

% table.model:42
size(table, _, [Top], length, length(Top)).
% table.model:43
size(table, _, [Top], width, width(Top)).
% table.model:44
size(table, _, [Top], height, elevation(Top)).
