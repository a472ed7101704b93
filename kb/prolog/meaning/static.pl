:- module(facetlog_static, [ static/1         % :Goal
                           ]).

/** <module> What does not depend on the scene

A mark for partial.pl, which asks such a goal once for a test, not again for each scene.
*/

:- meta_predicate static(0).

%!  static(:Goal) is semidet.
%
%   Goal, once; it follows from tests and rules alone.

static(Goal) :-
    call(Goal),
    !.
